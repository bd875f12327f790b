# SPDX-License-Identifier: Zlib
# Where Bullet is, for our build and, installed, for those who link us:
#   - targets of the same tree (Bullet by add_subdirectory or FetchContent); then no other Bullet is looked for;
#   - else Bullet's CMake config (CMAKE_PREFIX_PATH, Bullet_ROOT, Bullet_DIR);
#   - else pkg-config: bullet, bullet-float64.
# CLOD_BULLET_DEFINITIONS adds what no config of Bullet's tells, as BT_THREADSAFE=1 of a Bullet built so.
include_guard()
set(CLOD_BULLET_DEFINITIONS "" CACHE STRING "Definitions that Bullet was built with and does not tell")
mark_as_advanced(CLOD_BULLET_DEFINITIONS)

# clod_find_bullet(""|-float64): defines clod::bullet or clod::bullet-float64 where there is such a Bullet.
function(clod_find_bullet suffix)
	if(TARGET BulletDynamics AND TARGET BulletCollision AND TARGET LinearMath)
		_clod_bullet_of_the_tree("${suffix}")
	else()
		_clod_bullet_by_config("${suffix}")
		_clod_bullet_by_pkg_config("${suffix}")
	endif()
endfunction()

# Defines the target, unless it is known already or the definitions are of the other precision.
function(_clod_bullet_found suffix)
	cmake_parse_arguments(PARSE_ARGV 1 FOUND "" "" "INCLUDES;DIRECTORIES;LIBRARIES;DEFINITIONS")
	set(found_suffix "")
	if("BT_USE_DOUBLE_PRECISION" IN_LIST FOUND_DEFINITIONS)
		set(found_suffix -float64)
	endif()
	if(TARGET clod::bullet${suffix} OR NOT suffix STREQUAL found_suffix)
		return()
	endif()
	add_library(clod::bullet${suffix} INTERFACE IMPORTED GLOBAL)
	target_include_directories(clod::bullet${suffix} INTERFACE ${FOUND_INCLUDES})
	target_link_directories(clod::bullet${suffix} INTERFACE ${FOUND_DIRECTORIES})
	target_link_libraries(clod::bullet${suffix} INTERFACE ${FOUND_LIBRARIES})
	target_compile_definitions(clod::bullet${suffix} INTERFACE ${FOUND_DEFINITIONS} ${CLOD_BULLET_DEFINITIONS})
endfunction()

# Bullet's targets carry neither their include folder nor their definitions.
function(_clod_bullet_of_the_tree suffix)
	get_target_property(source LinearMath SOURCE_DIR)
	get_target_property(definitions LinearMath COMPILE_DEFINITIONS)
	list(FILTER definitions INCLUDE REGEX "^BT_")
	_clod_bullet_found("${suffix}" INCLUDES ${source}/.. LIBRARIES BulletDynamics BulletCollision LinearMath
		DEFINITIONS ${definitions})
endfunction()

# Paths in Bullet's config may be relative to its root; its list of libraries has some that packages leave out.
function(_clod_bullet_by_config suffix)
	find_package(Bullet CONFIG QUIET CONFIGS BulletConfig.cmake)
	if(suffix AND NOT BULLET_DEFINITIONS MATCHES "BT_USE_DOUBLE_PRECISION")
		find_package(Bullet CONFIG QUIET CONFIGS BulletConfig${suffix}.cmake)
	endif()
	if(NOT Bullet_FOUND)
		return()
	endif()
	set(libraries "")
	foreach(name BulletDynamics BulletCollision LinearMath)
		set(found ${BULLET_LIBRARIES})
		list(FILTER found INCLUDE REGEX ${name})
		list(APPEND libraries ${found})
	endforeach()
	list(TRANSFORM BULLET_INCLUDE_DIRS REPLACE "^([^/].*)" "${BULLET_ROOT_DIR}/\\1")
	list(TRANSFORM BULLET_LIBRARY_DIRS REPLACE "^([^/].*)" "${BULLET_ROOT_DIR}/\\1")
	separate_arguments(BULLET_DEFINITIONS)
	list(TRANSFORM BULLET_DEFINITIONS REPLACE "^-D" "")
	_clod_bullet_found("${suffix}" INCLUDES ${BULLET_INCLUDE_DIRS} DIRECTORIES ${BULLET_LIBRARY_DIRS}
		LIBRARIES ${libraries} DEFINITIONS ${BULLET_DEFINITIONS})
endfunction()

function(_clod_bullet_by_pkg_config suffix)
	find_package(PkgConfig QUIET)
	if(TARGET clod::bullet${suffix} OR NOT PKG_CONFIG_FOUND)
		return()
	endif()
	pkg_check_modules(CLOD_BULLET${suffix} QUIET bullet${suffix})
	set(definitions ${CLOD_BULLET${suffix}_CFLAGS_OTHER})
	list(FILTER definitions INCLUDE REGEX "^-DBT_")
	list(TRANSFORM definitions REPLACE "^-D" "")
	if(CLOD_BULLET${suffix}_FOUND)
		_clod_bullet_found("${suffix}" INCLUDES ${CLOD_BULLET${suffix}_INCLUDE_DIRS}
			DIRECTORIES ${CLOD_BULLET${suffix}_LIBRARY_DIRS} LIBRARIES ${CLOD_BULLET${suffix}_LIBRARIES}
			DEFINITIONS ${definitions})
	endif()
endfunction()
