#define PSIVOX_FLOAT_MARCH fused_march
#include "float_march_body.h"
