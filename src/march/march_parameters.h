#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "march/grids.h"
#include "march/marcher.h"
#include "psivox/medium.h"

namespace psivox {

class PreintegratedTable;

/// Numbers that the march reads; names and meaning in shaders/march_parameters.glsl.
struct MarchParameters {
  using real = double;
  using real2 = glm::dvec2;
  using real3 = glm::dvec3;
  using real4 = glm::dvec4;
  using int3 = glm::ivec3;
  using Grid = glsl::Grid;
#define PARAMETER(type, name) type name{};
#include "march_parameters.glsl"
#undef PARAMETER
};

/// Calls visit(name, value) for each parameter, by its name in the shaders:
/// `given.density.anchor_0`.
template <typename Visit>
void visit_parameters(const MarchParameters& parameters, const Visit& visit) {
  const auto visit_one = [&]<typename T>(const std::string& name, const T& value) {
    if constexpr (std::is_same_v<T, glsl::Grid>) {
#define PARAMETER(type, member) visit(name + "." #member, value.member);
#include "grid_parameters.glsl"
#undef PARAMETER
    } else {
      visit(name, value);
    }
  };
#define PARAMETER(type, name) visit_one("given." #name, parameters.name);
#include "march_parameters.glsl"
#undef PARAMETER
}

/// What a march is compiled for; names and meaning in shaders/march_constants.glsl.
struct MarchConstants {
#define CONSTANT(type, name) type name{};
#include "march_constants.glsl"
#undef CONSTANT
  Integrator integrator{};
  bool operator==(const MarchConstants&) const = default;
};

/// How far rays run beside a grid's voxels along each axis [voxels]: half of one where voxels are
/// cells of one value.
double beside_voxels(const MarchConstants& constants, int grid);

struct MarchSetup {
  MarchParameters parameters;
  MarchConstants constants;
  std::vector<glm::vec4> tables;  ///< what fetch_table reads, never empty
  int search_steps = 0;           ///< most loop turns of one look-up in them
  std::shared_ptr<const PreintegratedTable> preintegration;  ///< of that integrator, else null
  glm::ivec3 origin{0};  ///< voxel that the density's coordinates are relative to
};

/// Setup for a view and the atlases of its medium. max_turns is left at what a ray can need at
/// most, a bound: cells and nodes crossed, or steps.
MarchSetup make_march_setup(const View& view, const MediumAtlas& atlas,
                            const RenderOptions& options = {});

/// More turns than any ray of the march can take. `finest_step`: under uniform [unit of t].
double turn_bound(const MarchSetup& setup, double finest_step);

/// Throws Error(usage) if ray templates meet a grid of other voxels than the density's, or if the
/// uniform step is so short that float32 cannot tell where one step ends and the next begins: rays
/// would stand still.
void check_sampling(const View& view);

/// Largest value that an atlas holds, and 0.
double greatest_value(const BrickAtlas& atlas);

/// Bounds on the optical depth of a ray through the density.
struct DepthBounds {
  double whole = 0;
  double cell = 0;      ///< of its part in one cell
  double of_value = 0;  ///< of the attenuation, in units of the extinction
  double greatest = 0;  ///< of the values
};
DepthBounds depth_bounds(const Medium& medium, const MediumAtlas& atlas);

/// How cell_exact integrates a cell: Gauss-Legendre nodes, and the largest depth that they are
/// given at a time. Up to there the error in cells of random corners is at most 5e-5 of the largest
/// luminance, and 1e-6 RMS; in smooth cells it is a hundredth of that (docs/method.md).
struct CellNodes {
  int nodes = 0;
  double depth = 0;
};
CellNodes cell_nodes(double cell_depth);

}  // namespace psivox
