#include "draw/light_source.h"

namespace psivox {

LightDepths MediumDepths::at(std::size_t volume) const {
  if (volumes_) return volumes_->at(volume);
  if (volume == 0) return source_.depths(view_);
  return source_.depths(seen_from(view_, volume));  // the reference copies the view
}

ExactDepths MediumDepths::exact(const View& seen, std::size_t volume) const {
  if (!volumes_) return source_.exact_depths(seen);
  return [this, volume](const Beam& beam, std::span<const glm::ivec3> voxels) {
    return volumes_->exact(volume, beam, voxels);
  };
}

std::vector<std::vector<Crossed>> MediumDepths::crossed(std::size_t volume, const View& seen,
                                                        std::span<const glm::dvec2> places) const {
  if (volumes_) return crossed_cells(seen, volumes_->atlas(volume), places);
  return source_.crossed(seen, places);
}

}  // namespace psivox
