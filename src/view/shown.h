#pragma once

#include <glm/vec2.hpp>
#include <span>

#include "psivox/draw.h"
#include "psivox/scene.h"

namespace psivox::view {

/// The layer of a render that the window shows.
enum class ShownLayer { picture, steps, depth, error };

/// Their names, as --aov takes them.
inline constexpr const char* shown_layers[] = {"picture", "steps", "depth", "error"};

void ask_for(ShownLayer layer, Wish& wish);

/// Writes the layer into R G B A of the pictures as colours of viridis. Returns the values at the
/// two ends, which all pictures share. A is 0 where a ray has no depth. A picture without the layer
/// does not change.
glm::dvec2 show_layer(ShownLayer layer, std::span<Image> images);

/// The right side that a comparison starts with: twice the step.
Scene coarser(const Scene& scene);

/// The right side of a comparison: the method of `other`, except what would need another volume,
/// and the rest of `scene`.
Scene with_method_of(const Scene& other, Scene scene);

/// How much cheaper a preview is than the exact picture.
struct Rung {
  double divisor = 1;  ///< of width and height
  double step = 1;     ///< uniform step [voxels], if the scene's method has a step
  bool operator==(const Rung&) const = default;
};

/// Chooses the rung whose pictures take about as long as the budget allows, from the times of the
/// last ones.
class Pace {
 public:
  explicit Pace(double budget_ms) : budget_ms_(budget_ms) {}

  Rung rung() const;
  /// A picture of that rung took so long [ms].
  void took(const Rung& rung, double ms);
  /// The volume or scene changed: known costs are worth little, but the rung stays.
  void forget() { known_ = false; }

 private:
  double budget_ms_;
  double cost_ms_ = 0;  ///< of the full picture, estimated from the last ones
  bool known_ = false;
  int index_ = 5;
};

/// The scene as a rung draws it: a lower resolution, and a uniform step if mode and rule allow one.
/// A surface is found in cells, and a rule that applies the transfer function has tables for its
/// own lengths.
Scene preview_scene(const Scene& scene, const Rung& rung);

}  // namespace psivox::view
