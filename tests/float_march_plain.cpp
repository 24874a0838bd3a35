#define PSIVOX_FLOAT_MARCH plain_march
#define PSIVOX_IN_ONE_FUNCTION
#include "float_march_body.h"
