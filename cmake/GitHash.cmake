# Writes OUTPUT, a header with the hash of the current commit, and `-dirty` if files differ from it;
# empty without git. It writes only on a change, so that little is recompiled.
execute_process(COMMAND git -C "${SOURCE}" describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE hash OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(hash "")
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#define PSIVOX_GIT_HASH \"${hash}\"\n")
