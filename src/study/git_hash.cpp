#include "git_hash.h"  // written by the build

#include "study/page.h"

const char* psivox::git_hash() { return PSIVOX_GIT_HASH; }
