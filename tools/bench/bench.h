#pragma once

#include <string>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "psivox/field.h"

namespace psivox::bench {

/// Procedural fog: seven soft spheres times value noise, with values in [0,1]. n^3 voxels of width
/// 2/n around the origin, about 20 % of them active. At n = 256 it is the scene that peers are
/// measured on.
Field make_fog(int n);

inline double median(std::vector<double> values) { return spread_of(std::move(values)).median; }

/// Whether this renderer (GL_RENDERER) is Mesa's on the CPU, whose work is measured in CPU time.
inline bool is_software(const std::string& renderer) {
  return renderer.find("llvmpipe") != std::string::npos;
}

}  // namespace psivox::bench
