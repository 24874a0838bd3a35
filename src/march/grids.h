#pragma once

#include <array>

#include "march/glsl_subset.h"
#include "march/medium_atlas.h"

namespace psivox {

/// The grids that the march reads, as shaders/grids.glsl lists them: density_grid and so on.
enum GridId : int {
#define GRID(id, name) name##_grid = id,
#include "grids.glsl"
#undef GRID
};

#define GRID(id, name) +1
inline constexpr int grid_count = 0
#include "grids.glsl"
    ;
#undef GRID

/// A T for each grid, by its id.
template <typename T>
using PerGrid = std::array<T, grid_count>;

/// The medium's atlases; null where it has no such grid.
inline PerGrid<const BrickAtlas*> grids_of(const MediumAtlas& atlas) {
  const auto pointer = [](const auto& grid) -> const BrickAtlas* {
    if constexpr (requires { grid.has_value(); })
      return grid ? &*grid : nullptr;
    else
      return &grid;
  };
  PerGrid<const BrickAtlas*> all{};
#define GRID(id, name) all[id] = pointer(atlas.name);
#include "grids.glsl"
#undef GRID
  return all;
}

namespace glsl {

/// Numbers of one grid; names and meaning in shaders/grid_parameters.glsl.
struct Grid {
#define PARAMETER(type, name) type name{};
#include "grid_parameters.glsl"
#undef PARAMETER
};

}  // namespace glsl
}  // namespace psivox
