#include "draw/light_pilots.h"

#include <algorithm>

namespace psivox {

BeamsOn beams_of(const std::vector<Beam>& beams) {
  return [&beams](const View& seen, std::size_t volume) { return beams_on(seen, volume, beams); };
}

BeamsOn sky_of(int count) {
  return [count](const View& seen, std::size_t) { return sky_beams(seen, count); };
}

LightPilots::LightPilots(const View& view, const MediumDepths& depths, const BeamsOn& beams) {
  for (std::size_t i = 0; i < depths.volumes(); ++i) {
    volumes_.emplace_back();
    if (is_to_be_lit(view, i))
      volumes_.back() = std::make_unique<Volume>(seen_from(view, i), i, depths, beams);
  }
}

LightError LightPilots::error(const Medium& lit) const {
  return sum_of([&](std::size_t i) { return of(i).error(i == 0 ? lit : lit.others[i - 1]); });
}

LightError LightPilots::error(const BeamsOn& beams) const {
  return sum_of(
      [&](std::size_t i) { return of(i).error(LitLuminance(view(i), beams(view(i), i))); });
}

double LightPilots::coverage() const {
  double sum = 0;
  for (const auto& volume : volumes_)
    if (volume) sum += volume->pilot.coverage();
  return sum;
}

LightError LightPilots::sum_of(const std::function<LightError(std::size_t)>& error) const {
  LightError sum;
  for (std::size_t i = 0; i < volumes_.size(); ++i) {
    if (!volumes_[i]) continue;
    const LightError own = error(i);
    sum = {sum.rms + own.rms, std::max(sum.max, own.max)};
  }
  return sum;
}

}  // namespace psivox
