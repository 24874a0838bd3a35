#pragma once

#include <array>
#include <cstddef>
#include <glm/vec4.hpp>
#include <span>

#include "march/march_parameters.h"

namespace psivox {

/// A pixel's ray, marched in float32 on the CPU.
struct FloatRay {
  std::array<std::byte, 80> ray{};  ///< the shaders' Ray
  glm::vec4 picture{0};
  float end = 0, reached = 0;  ///< of the ray inside the domain; where the march ended
  bool stuck = false;          ///< it stood still
};

/// The rays of the pixels and their march, from the GPU's source.
struct FloatMarch {
  using Pixels = void (*)(const MarchSetup&, const MediumAtlas&, int width, std::span<FloatRay>);
  Pixels make_rays, march;
};

/// As the source has it.
extern const FloatMarch plain_march;
/// A product and a sum are rounded once, wherever the compiler likes but in what is `precise`, as
/// GPUs' compilers do.
extern const FloatMarch fused_march;

}  // namespace psivox
