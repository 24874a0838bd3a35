// Everything that marches, for a program's `draw`. integrator.glsl is written for each program: the file
// of its rule and the functions that call it (src/gl/march_program.cpp).
#include "stage.glsl"
#include "binding.glsl"
#include "formulas.glsl"
#include "medium.glsl"
#include "integrator.glsl"
#include "march.glsl"
