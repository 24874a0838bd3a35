#define PSIVOX_FLOAT_MARCH plain_march
#include "float_march_body.h"
