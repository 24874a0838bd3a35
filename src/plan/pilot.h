#pragma once

#include <span>

#include "march/march_double.h"
#include "march/marcher.h"
#include "medium/backdrop.h"

namespace psivox {

/// A view by a method, with the steps that the method takes in each brick.
struct MethodView {
  View view;
  BrickSteps brick_steps;  ///< null: one step everywhere
  bool paired = false;     ///< the luminance is stored beside the density
};

/// The view by that method, without a tolerance.
View with_method(View view, const Method& method);

/// The method with the least error, whatever its cost.
Method exact_method(const View& view);

/// Whether the medium of a voxel is homogeneous, so that a homogeneous step through it is exact.
bool has_plain_voxels(const Medium& medium);

/// Uniform steps by the rule with which lattices are first tried: psi-balanced, or midpoint where
/// something emits, of which other rules look up two values a step.
Method lattice(const View& view, double step);

/// Time of one look-up of a method, with its share of the loop, relative to psi-balanced between
/// uniform samples. Measured on llvmpipe by tools/bench/tolerance.py (docs/performance.md).
double look_up_cost(const Method& method, const MethodView& marched);

/// Contribution of float32 arithmetic to a picture's RMS error (docs/method.md).
inline constexpr double arithmetic_error = 4e-7;

/// What a method shows on one ray of the pilot, against the truth.
struct RayError {
  double squares = 0;  ///< sum over R G B A of the squared errors
  double largest = 0;  ///< of a channel
  double samples = 0;  ///< field look-ups
};

/// Some of a picture's rays, marched in double precision, for trying methods.
class Pilot {
 public:
  /// `exact`: the view by the method that counts as the truth. `ended`: the same, but its rays end
  /// as the picture's do. `behind`: the picture's. `progress`: see plan_march.
  Pilot(const View& exact, const View& ended, const Backdrop& behind, const MediumAtlas& atlas,
        const Progress& progress);

  /// The pilot's picture, marched exactly.
  const Image& truth() const { return truth_; }
  /// What is behind its pixels.
  const Backdrop& behind() const { return behind_; }
  /// Errors of the exact method, by ray, with the picture's early termination.
  std::span<const RayError> exact_errors() const { return exact_errors_; }
  /// Field look-ups of the truth, by ray.
  std::span<const double> exact_samples() const { return exact_samples_; }
  /// Rays that show anything.
  int telling_rays() const;
  /// Largest radiance of a ray, without what is behind the medium.
  double brightest() const;

  /// All rays, in an order whose every beginning is spread evenly over the picture.
  std::span<const int> even_order() const { return order_; }
  /// The march of a method on the pilot's rays.
  PixelMarch march_of(const MethodView& marched) const;
  /// Marches some rays and sets their errors. Both lists are of all rays and of these, in turn.
  void march(const PixelMarch& march, std::span<const int> rays, std::span<RayError> errors);

  /// Field look-ups of all that was marched.
  std::uint64_t all_samples() const { return all_samples_; }

 private:
  std::vector<glm::ivec2> pixels_of(std::span<const int> rays) const;
  RayError error_of(int ray, const MarchedRay& marched) const;

  const MediumAtlas& atlas_;
  Progress progress_;
  Image truth_;
  Backdrop behind_;
  std::vector<int> order_;
  std::vector<RayError> exact_errors_;
  std::vector<double> exact_samples_;
  std::uint64_t all_samples_ = 0;
};

}  // namespace psivox
