#include "draw/whole_atlas.h"

#include <algorithm>
#include <atomic>

#include "psivox/stopwatch.h"

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
  coded_.clear();
  atlases_.clear();
  uploads_.clear();
}

const MediumAtlas& WholeAtlas::of(const View& view, TexelType texel, PreparationTimes& times) {
  texel = host_texel(texel);
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
  if (const CodeWidths widths = fixed_widths(wanted, texel))
    return upload_coded(marcher, view, widths, times);
  std::uint64_t& number = uploads_[{texel, filter}];
  if (number != 0 && marcher.holds == number) return;
  marcher.holds = 0;
  marcher.upload(wanted, filter);
  marcher.holds = number = next_upload();
}

void WholeAtlas::upload_coded(Marcher& marcher, const View& view, const CodeWidths& widths,
                              PreparationTimes& times) {
  const Coded& codes = coded_of(view, widths, times);
  if (marcher.holds == codes.number) return;
  marcher.holds = 0;
  marcher.upload(codes.atlas, Filter::exact);
  marcher.holds = codes.number;
}

CodeWidths WholeAtlas::held_codes(const Marcher& marcher) const {
  for (const Coded& codes : coded_)
    if (codes.number == marcher.holds) return codes.widths;
  return {};
}

WholeAtlas::Coded& WholeAtlas::coded_of(const View& view, const CodeWidths& widths,
                                        PreparationTimes& times) {
  const auto found =
      std::ranges::find_if(coded_, [&](const Coded& codes) { return *codes.widths == *widths; });
  if (found != coded_.end()) {
    coded_.splice(coded_.begin(), coded_, found);
    return coded_.front();
  }
  const MediumAtlas& atlas = of(view, TexelType::float32, times);
  const Stopwatch watch;
  coded_.push_front({widths, coded(atlas, *widths), next_upload()});
  if (coded_.size() > 2) coded_.pop_back();
  times.atlas_ms += watch.ms();
  return coded_.front();
}

void WholeAtlas::relight(const View& view) {
  coded_.clear();
  View shining = view;
  for (auto& [texel, lit] : atlases_) {
    shining.scene.texel = texel;
    add_luminance(lit, shining);
  }
  uploads_.clear();
}

}  // namespace psivox
