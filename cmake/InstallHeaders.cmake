# SPDX-License-Identifier: Zlib
# At install time: copies `headers`, and what they include with clod/, from `root` to `destination`.
cmake_policy(VERSION 3.25)
set(wanted ${headers})
set(copied "")
while(wanted)
	list(POP_FRONT wanted header)
	if(header IN_LIST copied OR NOT EXISTS ${root}/${header})  # not in root: of a component that this one depends on
		continue()
	endif()
	list(APPEND copied ${header})
	get_filename_component(folder ${header} DIRECTORY)
	file(INSTALL ${root}/${header} DESTINATION ${destination}/${folder})
	file(STRINGS ${root}/${header} includes REGEX "^#include \"clod/")
	list(TRANSFORM includes REPLACE "^#include \"(clod/[^\"]*)\".*" "\\1")
	list(APPEND wanted ${includes})
endwhile()
