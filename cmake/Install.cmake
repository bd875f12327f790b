# SPDX-License-Identifier: Zlib
# cmake --install, by components, and the .deb files of each (cpack -G DEB):
#   plugin   clod::core, clod::clod, clod::clod-float64: libraries, headers, CMake and pkg-config files   libclod-dev
#   builder  clod::builder, GPL                                                                    libclod-builder-dev
#   tools    clod-build, clod-bench, their manual pages and completion                                      clod-tools
include(CMakePackageConfigHelpers)
set(CLOD_CONFIG_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/clod)

# What a library is to others: its file, its CMake target, its pkg-config file.
function(clod_install_library target name pc component)
	install(TARGETS ${target} EXPORT clod-${name}
		ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component}
		LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component})
	install(EXPORT clod-${name} NAMESPACE clod:: FILE clod-${name}-targets.cmake DESTINATION ${CLOD_CONFIG_DIR}
		COMPONENT ${component})
	configure_file(cmake/${pc}.pc.in ${PROJECT_BINARY_DIR}/pkgconfig/${pc}.pc @ONLY)
	install(FILES ${PROJECT_BINARY_DIR}/pkgconfig/${pc}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
		COMPONENT ${component})
endfunction()

# Headers that users include, and what those include: the rest stays inside.
function(clod_install_headers component root)
	install(CODE "
		set(root \"${root}\")
		set(headers \"${ARGN}\")
		set(destination \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}\")
		include(\"${PROJECT_SOURCE_DIR}/cmake/InstallHeaders.cmake\")" COMPONENT ${component})
endfunction()

function(clod_install_licence component package)
	install(FILES ${ARGN} DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${package} COMPONENT ${component}
		RENAME copyright)
	install(FILES CHANGES.md DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${package} COMPONENT ${component})
endfunction()

# pkg-config files say where they are, so that a prefix can be moved.
file(RELATIVE_PATH CLOD_PC_PREFIX /x/${CMAKE_INSTALL_LIBDIR}/pkgconfig /x)
string(REGEX REPLACE "/$" "" CLOD_PC_PREFIX "${CLOD_PC_PREFIX}")
clod_install_library(clod_core core clod-core plugin)
set(CLOD_PUBLIC_HEADERS clod/Version.h clod/hierarchy/Hierarchy.h clod/query/Query.h clod/query/ContactMetric.h
	clod/distance/SignedGap.h clod/manifold/ContactPoints.h)
foreach(suffix "" -float64)
	if(TARGET clod::clod${suffix})
		get_target_property(target clod::clod${suffix} ALIASED_TARGET)
		clod_install_library(${target} clod${suffix} clod${suffix} plugin)
		list(APPEND CLOD_PUBLIC_HEADERS clod/bullet/btClodShape.h clod/bullet/btClodCollisionAlgorithm.h
			clod/bullet/btClodDispatcher.h clod/bullet/btClodDynamicsWorld.h clod/bullet/ConfigureWorld.h)
	endif()
endforeach()
list(REMOVE_DUPLICATES CLOD_PUBLIC_HEADERS)
clod_install_headers(plugin ${PROJECT_SOURCE_DIR}/plugin ${CLOD_PUBLIC_HEADERS})
configure_package_config_file(cmake/clod-config.cmake.in ${PROJECT_BINARY_DIR}/clod-config.cmake
	INSTALL_DESTINATION ${CLOD_CONFIG_DIR} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/clod-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/clod-config.cmake ${PROJECT_BINARY_DIR}/clod-config-version.cmake
	cmake/clod-bullet.cmake DESTINATION ${CLOD_CONFIG_DIR} COMPONENT plugin)
clod_install_licence(plugin libclod-dev LICENSE.Zlib)

if(TARGET clod_builder)
	clod_install_library(clod_builder builder clod-builder builder)
	clod_install_headers(builder ${PROJECT_SOURCE_DIR}/builder/library clod/builder/Builder.h)
	clod_install_licence(builder libclod-builder-dev LICENSE.GPL-3.0)
endif()

include(cmake/InstallTools.cmake)
include(cmake/Packages.cmake)
