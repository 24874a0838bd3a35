#include "draw/whole_atlas.h"

#include <atomic>
#include <utility>

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
  return empty() ? 0 : double((atlas_ ? *atlas_ : coded_->atlas).size().bytes());
}

void WholeAtlas::clear() {
  coded_.reset();
  atlas_.reset();
  uploads_.clear();
}

const MediumAtlas& WholeAtlas::of(const View& view, std::optional<Field> density) {
  if (atlas_) return *atlas_;
  const Stopwatch watch;
  atlas_ = build_medium_atlas(view, std::move(density));
  ms += watch.ms();
  return *atlas_;
}

const MediumAtlas& WholeAtlas::on_device(const View& view, TexelType texel, const CodeWidths& codes,
                                         bool last) {
  const MediumAtlas& atlas = of(view);
  const CodeWidths widths = codes ? codes : fixed_widths(atlas, texel);
  if (!widths) return atlas;
  if (coded_ && *coded_->widths == *widths) return coded_->atlas;
  const Stopwatch watch;
  coded_.reset();  // before the next take memory
  coded_ = {widths, coded(last ? std::move(*atlas_) : *atlas_, *widths, last), next_upload()};
  if (last) atlas_.reset();
  ms += watch.ms();
  return coded_->atlas;
}

const MediumAtlas& WholeAtlas::upload(Marcher& marcher, const View& view, TexelType texel,
                                      Filter filter, const CodeWidths& codes, bool last) {
  const MediumAtlas& wanted = on_device(view, texel, codes, last);
  std::uint64_t& number = wanted.density.codes ? coded_->number : uploads_[filter];
  if (number == 0 || marcher.holds != number) {
    marcher.holds = 0;
    marcher.upload(wanted, filter);
    if (number == 0) number = next_upload();
    marcher.holds = number;
  }
  return wanted;
}

void WholeAtlas::relight(const View& view, std::optional<Field> luminance) {
  coded_.reset();
  if (atlas_) add_luminance(*atlas_, view, std::move(luminance));
  uploads_.clear();
}

}  // namespace psivox
