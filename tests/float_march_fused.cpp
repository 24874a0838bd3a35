#define PSIVOX_FLOAT_MARCH fused_march
// as GPUs compile it: else calls would keep products from sums
#define PSIVOX_IN_ONE_FUNCTION [[gnu::flatten]]
#include "float_march_body.h"
