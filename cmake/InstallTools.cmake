# SPDX-License-Identifier: Zlib
# The programs that are built, a manual page of each from its own --help, and their completion in bash.
set(CLOD_TOOLS "")
foreach(tool clod-build clod-bench clod-bench-float64)
	if(TARGET ${tool})
		list(APPEND CLOD_TOOLS ${tool})
	endif()
endforeach()
if(NOT CLOD_TOOLS)
	return()
endif()
if(BUILD_SHARED_LIBS)
	set_target_properties(${CLOD_TOOLS} PROPERTIES INSTALL_RPATH $ORIGIN/../${CMAKE_INSTALL_LIBDIR})
endif()
install(TARGETS ${CLOD_TOOLS} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT tools)
set(licences LICENSE.Zlib)
if(TARGET clod-build)
	set(licences LICENSE.GPL-3.0)  # of the package as a whole
endif()
clod_install_licence(tools clod-tools ${licences})

if(CMAKE_CROSSCOMPILING)
	return()  # the programs cannot be asked
endif()
set(pages "")
foreach(tool IN LISTS CLOD_TOOLS)
	set(page ${PROJECT_BINARY_DIR}/man/${tool}.1.gz)
	add_custom_command(OUTPUT ${page} DEPENDS ${tool} ${PROJECT_SOURCE_DIR}/scripts/man-page
		COMMAND ${PROJECT_SOURCE_DIR}/scripts/man-page $<TARGET_FILE:${tool}> ${page} VERBATIM)
	list(APPEND pages ${page})
	install(FILES ${PROJECT_SOURCE_DIR}/scripts/completion.bash RENAME ${tool} COMPONENT tools
		DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/bash-completion/completions)
endforeach()
add_custom_target(clod_man_pages ALL DEPENDS ${pages})
install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT tools)
