# SPDX-License-Identifier: Zlib
# Sets CLOD_VERSION to what plugin/clod/Version.h says.
set(CLOD_VERSION "")
foreach(part MAJOR MINOR PATCH)
	file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/../plugin/clod/Version.h line REGEX "#define CLOD_VERSION_${part} [0-9]+")
	string(REGEX REPLACE ".* " "" number "${line}")
	list(APPEND CLOD_VERSION ${number})
endforeach()
list(JOIN CLOD_VERSION . CLOD_VERSION)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/../plugin/clod/Version.h)
