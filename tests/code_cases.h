#pragma once

#include <vector>

#include "march_cases.h"

// Shared by the tests of codes.

namespace psivox {

inline Scene oblique() { return oblique(64, 0.12); }

inline Scene by(Scene scene, bool cells) {
  if (cells)
    scene.integrator = Integrator::cell_exact;
  else
    scene.step = 0.7;
  return scene;
}

/// Neighbouring bricks differ.
inline std::vector<CodeWidth> widths_in_turn(const MediumAtlas& atlas) {
  std::vector<CodeWidth> widths(atlas.density.bricks.size());
  for (std::size_t i = 0; i < widths.size(); ++i) widths[i] = CodeWidth(i % 3);
  return widths;
}

inline MediumAtlas coded_in_turn(const MediumAtlas& atlas) {
  return coded(atlas, widths_in_turn(atlas));
}

}  // namespace psivox
