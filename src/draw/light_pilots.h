#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "march/light_pilot.h"
#include "march/volume_depths.h"

namespace psivox {

/// Where optical depths towards lights come from: through the atlas of the whole, or part by part.
/// Of several volumes those of a marcher are through the first alone.
struct LightSource {
  std::function<LightDepths(const View& view)> depths;
  std::function<LightPilot::Depths(const View& view)> exact_depths;
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

  LightDepths at(std::size_t volume) const {
    if (volumes_) return volumes_->at(volume);
    if (volume == 0) return source_.depths(view_);
    return source_.depths(seen_from(view_, volume));  // the reference copies the view
  }
  /// Exact, from voxels of a volume of the medium by any camera.
  LightPilot::Depths exact(const View& seen, std::size_t volume) const {
    if (!volumes_) return source_.exact_depths(seen);
    return [this, volume](const Beam& beam, std::span<const glm::ivec3> voxels) {
      return volumes_->exact(volume, beam, voxels);
    };
  }
  const LightShare& share() const { return source_.share; }
  std::size_t volumes() const { return 1 + view_.medium.others.size(); }

 private:
  const View& view_;
  const LightSource& source_;
  std::optional<VolumeDepths> volumes_;
};

/// Beams on a view's volume, the first of what is `seen` from it.
using BeamsOn = std::function<std::vector<Beam>(const View& seen, std::size_t volume)>;

/// The beams of the first volume, on each. They must outlive what it returns.
BeamsOn beams_of(const std::vector<Beam>& beams);
/// Beams of the sky from so many directions.
BeamsOn sky_of(int count);

/// Pilots of all volumes of a medium. What a picture misses in the light of each adds up, at most;
/// the largest errors are rarely in one pixel.
class LightPilots {
 public:
  /// View and depths must outlive them.
  LightPilots(const View& view, const MediumDepths& depths, const BeamsOn& beams);

  const View& view(std::size_t volume) const { return volumes_[volume]->view; }
  const LightPilot& of(std::size_t volume) const { return volumes_[volume]->pilot; }

  /// What a lit medium misses.
  LightError error(const Medium& lit) const;
  /// What other beams miss, in exact light.
  LightError error(const BeamsOn& beams) const;
  /// LightPilot::coverage() of all.
  double coverage() const;
  /// The errors of all volumes that are lit, together.
  LightError sum_of(const std::function<LightError(std::size_t volume)>& error) const;

 private:
  struct Volume {
    Volume(View seen, std::size_t i, const MediumDepths& depths, const BeamsOn& beams)
        : view(std::move(seen)),
          luminance(view, beams(view, i)),
          pilot(view, depths.exact(view, i), luminance, depths.share()) {}
    View view;
    LitLuminance luminance;
    LightPilot pilot;
  };

  std::vector<std::unique_ptr<Volume>> volumes_;  ///< null: it is not to be lit
};

}  // namespace psivox
