# Writes OUTPUT, a header with the hash of the commit that is built and `-dirty` where files differ
# from it; empty where there is no git. Only if it changed, so that little is compiled again.
execute_process(COMMAND git -C "${SOURCE}" describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE hash OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(hash "")
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#define PSIVOX_GIT_HASH \"${hash}\"\n")
