#pragma once

#include <cstdio>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "psivox/error.h"
#include "psivox/field.h"

namespace psivox::bench {

/// Procedural fog: seven soft spheres times value noise, with values in [0,1]. n^3 voxels of width
/// 2/n around the origin, about 20 % of them active. At n = 256 it is the scene that peers are
/// measured on.
Field make_fog(int n);

inline double median(std::vector<double> values) { return spread_of(std::move(values)).median; }

/// Runs a benchmark. An Error becomes a line on stderr, and the exit code.
template <typename Work>
int run(const char* name, const Work& work) {
  try {
    work();
    return 0;
  } catch (const Error& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return int(error.code());
  }
}

}  // namespace psivox::bench
