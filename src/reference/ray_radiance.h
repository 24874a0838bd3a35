#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "cell_walk.h"
#include "piece.h"
#include "psivox/field.h"
#include "psivox/medium.h"
#include "scene/cuts.h"

namespace psivox {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double epsilon = std::numeric_limits<double>::epsilon();

struct RaySum;

struct RayRadiance {
  glm::dvec3 radiance{0};
  double optical_depth = 0;  ///< up to the point where the walk stopped
  double error = 0;          ///< bound on the error of the worst channel and of the opacity
  std::uint64_t cells = 0;   ///< crossed, with a corner that is not 0, up to the stop
};

/// A medium prepared for rays, shared by threads.
struct RayMedium {
  explicit RayMedium(const Medium& m);

  Medium medium;
  FieldIndex density;
  std::optional<FieldIndex> luminance;  ///< if a grid other than density gives L
  std::optional<FieldIndex> gradient;   ///< if the transfer function has one
  std::vector<FieldIndex> emission{};
  std::vector<RayMedium> others{};  ///< further volumes
  double behind_max;                ///< bound on the radiance of anything behind a point of a ray
};

/// Integrates rays through a medium, t0 <= t <= t1 [world units from the ray's origin]; one for
/// each thread.
class RayIntegrator {
 public:
  /// `medium` must outlive it. The sum stops at a transparency of tolerance / 10, divided by
  /// behind_max if that exceeds 1. The bound includes the rest.
  RayIntegrator(const RayMedium& medium, double tolerance);

  RayRadiance radiance(const WorldRay& ray, double t0 = 0, double t1 = infinity);

  /// Without radiance: optical depth up to the ray's end, however opaque, and its error.
  RayRadiance whole_depth(const WorldRay& ray, double t0 = 0, double t1 = infinity);

 private:
  /// Where a ray is in all grids: the integral goes by stretches in which each has one cell at
  /// most.
  struct Stretches;
  void begin(const WorldRay& ray, double t_middle, double t0, double t1, Stretches& at);
  void read_stretch(const Stretches& at, double a, double b, const Cubic& value,
                    Piece& piece) const;
  void add_volumes(const Stretches& at, double a, double b, RaySum& sum) const;
  void add_stretch(const Stretches& at, double a, double b, RaySum& sum);
  void classify_stretch(const Stretches& at, double a, double b, const Cubic& value);

  const RayMedium* medium_;
  bool color_at_end_;  ///< not in the pieces, which are alike but for it
  int channels_ = 3;   ///< of the pieces
  Accuracy accuracy_;
  BlockCache density_cache_;
  std::optional<BlockCache> luminance_cache_;
  std::optional<BlockCache> gradient_cache_;
  std::vector<BlockCache> emission_caches_;
  std::vector<ClassifiedPart> parts_;
  std::vector<RayIntegrator> others_;  ///< of further volumes
};

inline double max_component(const glm::dvec3& v) { return std::max(v.x, std::max(v.y, v.z)); }

/// Size of a crossing's coordinates in voxels; its position is off by epsilon times this size.
inline double extent(const Field& field) {
  const Box box = field.domain();
  return max_component(glm::dvec3(box.max) - glm::dvec3(box.min));
}

/// Sums over a ray. A factor of all pieces' radiance may be applied at the end.
struct RaySum {
  glm::dvec3 radiance{0};
  double optical_depth = 0;
  double T = 1;
  double error = 0;
  double depth_error = 0;  ///< bound on the rounding of the optical depth, beyond its terms'
  double glow = 0;         ///< bound on the emission's part of the radiance
  double L_max = 0;        ///< of the pieces so far
  std::uint64_t pieces = 0;
  std::uint64_t cells = 0;

  void pass(double depth) {
    optical_depth += depth;
    T = std::exp(-optical_depth);
    ++pieces;
  }

  void add(const Piece& piece, const Accuracy& accuracy) {
    const PieceRadiance r = integrate(piece, T, accuracy);
    const double depth = piece.optical_depth();
    for (int c = 0; c < piece.channels; ++c) radiance[c] += r.radiance[std::size_t(c)];
    error += r.error + piece.L_error * T * std::min(depth, 1.0);
    depth_error += piece.x_error;
    if (piece.glows) glow += T * piece.max_glow();
    L_max = std::max(L_max, piece.max_luminance());
    pass(depth);
  }

  /// Applies a colour that was left out of pieces of so many channels; of none, L is the colour.
  void multiply(int channels, const glm::dvec3& color) {
    if (channels == 0) L_max = 1;
    radiance = color * (channels == 0   ? glm::dvec3(opacity())
                        : channels == 1 ? glm::dvec3(radiance.x)
                                        : radiance);
    error *= max_component(glm::abs(color));
    L_max *= max_component(glm::abs(color));
  }

  double opacity() const { return -std::expm1(-optical_depth); }

  /// Bound on rounding's part of the error. A crossing is off by epsilon times its coordinates, a
  /// sum by epsilon times its terms; an error d of the optical depth changes L T, and everything
  /// behind it, by L d at most.
  double rounding(double extents) const { return rounding(extents, L_max, glow); }
  /// The bound for the opacity.
  double opacity_rounding(double extents) const { return rounding(extents, 1, 0); }

 private:
  double rounding(double extents, double L, double emission) const {
    const double roundings = 16 + double(pieces) + extents;
    return roundings * std::numeric_limits<double>::epsilon() * (opacity() * L + emission) +
           depth_error * (2 * L + emission);
  }
};

/// The contribution of one ray to a pixel.
struct RayPicture {
  glm::dvec3 radiance{0};  ///< premultiplied
  double opacity = 0;
  double error = 0;         ///< bound on the error of the worst channel of radiance and opacity
  double depth = infinity;  ///< of the maximum or the surface [world units]
  std::uint64_t cells = 0;  ///< crossed, with a corner that is not 0
};

/// Draws rays by the mode of a scene; one for each thread.
class RayModes {
 public:
  /// `view` and its `medium` must outlive it.
  RayModes(const View& view, const RayMedium& medium, double tolerance);

  /// The ray up to the distance `end` [world units].
  RayPicture picture(const WorldRay& ray, double end);

 private:
  RayPicture radiance(const WorldRay& ray);
  RayPicture depth(const WorldRay& ray);
  RayPicture maximum(const WorldRay& ray);
  RayPicture surface(const WorldRay& ray);

  const View* view_;
  const RayMedium* medium_;
  RayIntegrator integrator_;
  std::vector<HalfSpace> clip_;
  glm::dvec2 part_{0};                ///< of the ray that is drawn: before its end, in the clip
  std::optional<BlockCache> cache_;   ///< of the density grid, for maxima and surfaces
  std::optional<BlockCache> colors_;  ///< of the luminance's grid, for surfaces
};

}  // namespace psivox
