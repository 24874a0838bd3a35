#include "draw/whole_atlas.h"

#include <atomic>

#include "base/stopwatch.h"

namespace psivox {
namespace {

/// Numbers the uploads: each is one session's atlas with one texel type and one filter.
std::uint64_t next_upload() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

}  // namespace

double WholeAtlas::bytes() const {
  double bytes = 0;
  for (const auto& [texel, atlas] : atlases_) bytes += double(atlas.size().bytes());
  return bytes;
}

void WholeAtlas::clear() {
  atlases_.clear();
  uploads_.clear();
}

const MediumAtlas& WholeAtlas::of(const View& view, TexelType texel, PreparationTimes& times) {
  const auto found = atlases_.find(texel);
  if (found != atlases_.end()) return found->second;
  const Stopwatch watch;
  View converted = view;
  converted.scene.texel = texel;
  const MediumAtlas& built = atlases_.emplace(texel, build_medium_atlas(converted)).first->second;
  times.atlas_ms += watch.ms();
  return built;
}

void WholeAtlas::upload(Marcher& marcher, const View& view, TexelType texel, Filter filter,
                        PreparationTimes& times) {
  const MediumAtlas& wanted = of(view, texel, times);
  std::uint64_t& number = uploads_[{texel, filter}];
  if (number != 0 && marcher.holds == number) return;
  marcher.holds = 0;
  marcher.upload(wanted, filter);
  marcher.holds = number = next_upload();
}

void WholeAtlas::relight(const View& view) {
  View shining = view;
  for (auto& [texel, lit] : atlases_) {
    shining.scene.texel = texel;
    add_luminance(lit, shining);
  }
  uploads_.clear();
}

}  // namespace psivox
