#pragma once

#include <array>
#include <iterator>

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

static_assert(grid_count - emission_grid == std::size(emission_options));

/// The medium's atlases; null where it has no such grid.
inline PerGrid<const BrickAtlas*> grids_of(const MediumAtlas& atlas) {
  PerGrid<const BrickAtlas*> all{&atlas.density};
  if (atlas.luminance) all[luminance_grid] = &*atlas.luminance;
  if (atlas.gradient) all[gradient_grid] = &*atlas.gradient;
  if (atlas.others) all[others_grid] = &*atlas.others;
  std::size_t next = emission_grid;
  for (const BrickAtlas& grid : atlas.emission) all.at(next++) = &grid;
  return all;
}

/// The medium's fields, of one grid each; null where it has none.
inline PerGrid<const Field*> fields_of(const Medium& medium) {
  PerGrid<const Field*> all{medium.density.get()};
  all[luminance_grid] = medium.luminance.get();
  all[gradient_grid] = medium.gradient.get();
  std::size_t next = emission_grid;
  for (const Emission& emission : medium.emission) all.at(next++) = emission.field.get();
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
