#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "field/index_space.h"
#include "march/light.h"
#include "march/march_double.h"
#include "march/volume_depths.h"
#include "psivox/team.h"

namespace psivox {

/// What this process has of a medium that a team lights together; a process that is alone has all.
struct LightShare {
  Team* team = alone().get();
  /// Voxels that none but this process has.
  Box voxels = everywhere;

  bool together() const { return team->size() > 1; }
};

/// Exact optical depths from some voxels towards a beam, through the whole medium.
using ExactDepths =
    std::function<std::vector<double>(const Beam& beam, std::span<const glm::ivec3> voxels)>;

/// What rays of a view cross of its first volume (crossed_cells in march_double.h).
using CrossedCells = std::function<std::vector<std::vector<Crossed>>(
    const View& view, std::span<const glm::dvec2> places)>;

/// Where optical depths towards lights come from: through the atlas of the whole, or part by part.
/// Of several volumes those of a marcher are through the first alone.
struct LightSource {
  std::function<LightDepths(const View& view)> depths;
  std::function<ExactDepths(const View& view)> exact_depths;
  CrossedCells crossed;
  const MediumAtlas* atlas = nullptr;  ///< of the whole, if it is there
  LightShare share{};
};

/// Depths through the whole medium of a view, from voxels of each of its volumes.
class MediumDepths {
 public:
  /// View and source must outlive it.
  MediumDepths(const View& view, const LightSource& source) : view_(view), source_(source) {
    if (!view.medium.others.empty() && source.atlas)
      volumes_.emplace(view, source.atlas, source.depths);
  }

  LightDepths at(std::size_t volume) const;
  /// Exact, from voxels of a volume of the medium by any camera.
  ExactDepths exact(const View& seen, std::size_t volume) const;
  /// What rays cross of a volume, the first that is seen.
  std::vector<std::vector<Crossed>> crossed(std::size_t volume, const View& seen,
                                            std::span<const glm::dvec2> places) const;
  const LightShare& share() const { return source_.share; }
  std::size_t volumes() const { return 1 + view_.medium.others.size(); }

 private:
  const View& view_;
  const LightSource& source_;
  std::optional<VolumeDepths> volumes_;
};

}  // namespace psivox
