# SPDX-License-Identifier: Zlib
# Writes GitVersion.h with the current commit; leaves the file alone when nothing changed.
set(hash "unknown")
if(GIT)
	execute_process(COMMAND ${GIT} -C ${SOURCE} rev-parse --short=12 HEAD
		OUTPUT_VARIABLE answer OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
	if(NOT failed)
		set(hash ${answer})
	endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#define CLOD_GIT_HASH \"${hash}\"\n")
