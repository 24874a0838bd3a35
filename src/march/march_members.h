// No include guard: expanded inside a struct that supplies the edge functions of atlas.glsl. Makes
// it the march in double: parameters and constants as members, the shader's functions as member
// functions, from the same files that the GPU compiles. Tests define REAL_BITS and `precise`
// before, and make it the march in float.
#ifndef REAL_BITS
#define REAL_BITS 64
#define precise
#endif
#define INOUT(type) type&
#define IN(type) const type&
#define PSIVOX_ROW(name, value) static constexpr int name = int(value);
PSIVOX_SHADER_CONSTANTS(PSIVOX_ROW)
#undef PSIVOX_ROW
#define PARAMETER(type, name) type name{};
#define CONSTANT(type, name) type name{};
#include "march_constants.glsl"
#include "march_parameters.glsl"
#undef CONSTANT
#undef PARAMETER
Integrator integrator{};

real4 fetch_interval(int i) const { return fetch_table(transfer_first + i); }

// clang-format off
#include "formulas.glsl"
#include "medium.glsl"
#include "all_integrators.h"
#include "transfer_integrators.h"
// clang-format on

// This one and integrate_transfer hold all rules. They are not inlined: the compiler would take a
// quarter longer for the march.
[[gnu::noinline]] Weights integrate_segment(Segment s) {
  switch (integrator) {
#define PSIVOX_ROW(name, middle, exact, cost, help) \
  case Integrator::name:                            \
    return name(s);
    PSIVOX_SEGMENT_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
    default:
      return Weights(0, 0, 0, 0);
  }
}

real integrate_cell(Cubic c, real through, real s) {
  switch (integrator) {
#define PSIVOX_ROW(name, middle, exact, cost, help) \
  case Integrator::name:                            \
    return name(c, through, s);
    PSIVOX_CELL_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
    default:
      return 0;
  }
}

[[gnu::noinline]] Mixture integrate_transfer(real front, real back, real length) {
  switch (integrator) {
#define PSIVOX_ROW(name, middle, exact, cost, help) \
  case Integrator::name:                            \
    return name(front, back, length);
    PSIVOX_TRANSFER_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
    default:
      return Mixture(0, real3(0));
  }
}

#define DERIVED(type, name, expression) type name{};
#include "march.glsl"
#undef DERIVED

/// Sets what follows from the constants.
void derive() {
#define DERIVED(type, name, expression) name = expression;
#include "march_derived.glsl"
#undef DERIVED
}

void configure(const MarchSetup& setup) {
#define PARAMETER(type, name) name = type(setup.parameters.name);
#include "march_parameters.glsl"
#undef PARAMETER
#define CONSTANT(type, name) name = setup.constants.name;
#include "march_constants.glsl"
#undef CONSTANT
  integrator = setup.constants.integrator;
  derive();
}

March march_ray(real2 pixel) {
  const Pixel p = make_pixel(pixel);
  const Ray ray = march_ray_of(p);
  March m = begin_march(ray);
  aim(m, p);
  march(m, ray);
  return m;
}

#undef precise
#undef IN
#undef INOUT
#undef REAL_BITS
