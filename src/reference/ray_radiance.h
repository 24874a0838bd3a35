#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "cell_walk.h"
#include "classify.h"
#include "field_lookup.h"
#include "piece.h"
#include "psivox/medium.h"

namespace psivox {

struct RaySum;

struct RayRadiance {
  glm::dvec3 radiance{0};
  double optical_depth = 0;  ///< up to the point where the walk stopped
  double error = 0;          ///< bound on the error of the worst channel
  std::uint64_t cells = 0;   ///< crossed, with a corner that is not 0, up to the stop
};

struct RayDepth {
  double depth = 0;
  double error = 0;  ///< bound
  std::uint64_t cells = 0;
};

/// Cells that a ray crosses, to its end.
struct CellCount {
  std::uint64_t occupied = 0;   ///< with a corner that is not 0
  std::uint64_t in_blocks = 0;  ///< in 8x8x8 blocks whose 9x9x9 voxels are not all 0
};

/// A medium prepared for rays, shared by threads.
struct RayMedium {
  explicit RayMedium(const Medium& m);

  Medium medium;
  FieldLookup density;
  std::optional<FieldLookup> luminance;  ///< if a grid other than density gives L
  std::optional<FieldLookup> emission;
  std::optional<FieldLookup> gradient;  ///< if the transfer function has one
  glm::dvec3 color;                     ///< factor of a grid's value, or L itself
  double L_max;                         ///< bound on |L| anywhere
  double behind_max;  ///< bound on the radiance of anything behind a point of a ray
};

/// Integrates rays through a medium, t0 <= t <= t1 [world units from the ray's origin]; one for
/// each thread.
class RayIntegrator {
 public:
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  /// `medium` must outlive it. The sum stops at a transparency of tolerance / 10, divided by
  /// behind_max if that exceeds 1. The bound includes the rest.
  RayIntegrator(const RayMedium& medium, double tolerance);

  RayRadiance radiance(const WorldRay& ray, double t0 = 0, double t1 = infinity);

  /// Optical depth up to the ray's end, however opaque.
  RayDepth whole_depth(const WorldRay& ray, double t0 = 0, double t1 = infinity);
  double optical_depth(const WorldRay& ray, double t0 = 0, double t1 = infinity);
  CellCount count_cells(const WorldRay& ray, double t0 = 0, double t1 = infinity);

 private:
  void add_whole(const CellPiece& cell, const std::array<double, 8>& corners, const IndexRay& ray,
                 RaySum& sum) const;
  void add_across_grid(const CellPiece& cell, const std::array<double, 8>& corners,
                       const IndexRay& density_ray, const IndexRay& luminance_ray, RaySum& sum);

  // With a transfer function or emission (ray_stretches.cpp), the integral goes by stretches in
  // which every grid has at most one cell.
  struct Stretches;
  RayRadiance radiance_by_stretches(const WorldRay& ray, double t0, double t1);
  RayDepth depth_by_stretches(const WorldRay& ray, double t0, double t1);
  void add_stretch(const Stretches& at, double a, double b, RaySum& sum);
  void classify_stretch(const Stretches& at, double a, double b);

  const RayMedium* medium_;
  bool by_stretches_;
  Accuracy accuracy_;
  BlockCache density_cache_;
  std::optional<BlockCache> luminance_cache_;
  std::optional<BlockCache> emission_cache_;
  std::optional<BlockCache> gradient_cache_;
  std::vector<ClassifiedPart> parts_;
};

/// Prepares the medium for a single ray and integrates it.
RayRadiance ray_radiance(const Medium& medium, const WorldRay& ray, double tolerance = 1e-12);

/// Optical depth of extinction * field, exact except for rounding.
double optical_depth(const Field& field, double extinction, const WorldRay& ray, double t0 = 0,
                     double t1 = RayIntegrator::infinity);

}  // namespace psivox
