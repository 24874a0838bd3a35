// The formulas; each file uses the ones before it.
#include "math/decay.glsl"
#include "math/psi.glsl"
#include "math/mills.glsl"
#include "math/dawson.glsl"
#include "math/linear_psi.glsl"
#include "math/segment.glsl"
#include "math/cubic.glsl"
#include "math/glow.glsl"
