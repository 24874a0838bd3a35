// The formulas; each file uses the ones before it.
#include "math/decay.glsl"
#include "math/linear_psi.glsl"
#include "math/segment.glsl"
#include "math/cubic.glsl"
