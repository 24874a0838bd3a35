#pragma once

#include <string>
#include <vector>

#include "march/marcher.h"
#include "psivox/draw.h"

namespace psivox::gpu_cost {

/// A scene over assets/blobs.vdb whose program for the picture is measured.
struct Listed {
  std::string name;
  std::string scene;  ///< JSON, as --scene reads it; transfer functions by their names in assets/
  int registers = 0;  ///< least so far: vector registers on navi21
  std::string shader = "march.frag";
};

/// The list, in the order of the table.
const std::vector<Listed>& listed_programs();

/// Turns of the march's loop and look-ups in bricks, by the march in double.
struct RayCounts {
  double turns = 0;  ///< mean of a ray
  double wave_turns =
      0;  ///< mean of the longest ray among 8x8 pixels, which a wave of 64 lanes waits for
  double look_ups = 0;  ///< mean of a ray
};

/// A program that a picture needs.
struct Program {
  std::string shader;
  std::string text;  ///< GLSL, as a GPU's driver gets it
  RayCounts rays{};  ///< where they were counted
};

/// Draws a scene's picture on no device at all: returns the programs that a GPU would draw it with,
/// the picture's last. `count_rays`: those of the picture, in one of 16x16 blocks of its pixels.
std::vector<Program> programs_of(const Scene& scene, bool count_rays);

}  // namespace psivox::gpu_cost
