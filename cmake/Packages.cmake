# SPDX-License-Identifier: Zlib
# cpack -G DEB: a package a component, of what was built.
set(CPACK_PACKAGE_NAME clod)
set(CPACK_PACKAGE_VENDOR clod)
set(CPACK_PACKAGE_CONTACT "clod maintainers <clod@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Contact levels of detail for moving triangle meshes in Bullet")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL plugin)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION libdevel)

# The adapter is of the Bullet it was built with: the next version of Bullet needs another build (clod/bullet/Abi.h).
set(CPACK_DEBIAN_PLUGIN_PACKAGE_NAME libclod-dev)
set(CPACK_DEBIAN_PLUGIN_DESCRIPTION "Libraries and headers: shapes for moving, concave, detailed triangle meshes,
exact or as exact as asked for, in float and double builds of Bullet. Zlib
licence.")
set(CPACK_DEBIAN_PLUGIN_PACKAGE_DEPENDS "libbullet-dev")
find_program(CLOD_DPKG_QUERY dpkg-query)
mark_as_advanced(CLOD_DPKG_QUERY)
if(CLOD_DPKG_QUERY)
	execute_process(COMMAND ${CLOD_DPKG_QUERY} -W "-f=\${source:Upstream-Version}" libbullet-dev
		OUTPUT_VARIABLE bullet ERROR_QUIET RESULT_VARIABLE failed)
	if(NOT failed AND bullet MATCHES "^[0-9]+\\.[0-9]+")
		set(CPACK_DEBIAN_PLUGIN_PACKAGE_DEPENDS "libbullet-dev (>= ${CMAKE_MATCH_0}), libbullet-dev (<< ${CMAKE_MATCH_0}.99)")
	endif()
endif()

if(TARGET clod_builder)
	list(APPEND CPACK_COMPONENTS_ALL builder)
	set(CPACK_DEBIAN_BUILDER_PACKAGE_NAME libclod-builder-dev)
	set(CPACK_DEBIAN_BUILDER_DESCRIPTION "The builder as a library. GPL-3.0-or-later, as it contains CGAL: a program that
links it is GPL. Programs that only load what it built link libclod-dev, whose
licence is zlib.")
	set(CPACK_DEBIAN_BUILDER_PACKAGE_DEPENDS "libclod-dev (= ${PROJECT_VERSION}), libgmp-dev, libmpfr-dev, libfmt-dev, libtinygltf-dev")
endif()

if(CLOD_TOOLS)
	list(APPEND CPACK_COMPONENTS_ALL tools)
	set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME clod-tools)
	set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION utils)
	set(CPACK_DEBIAN_TOOLS_DESCRIPTION "The programs: clod-build makes .clod files from triangle meshes
(GPL-3.0-or-later), clod-bench measures and shows them in Bullet.")
	set(CPACK_DEBIAN_TOOLS_PACKAGE_SHLIBDEPS ON)
	set(CPACK_DEBIAN_TOOLS_PACKAGE_RECOMMENDS "fonts-dejavu-core, ffmpeg, gnuplot-nox")
endif()
include(CPack)
