#include "draw/whole_atlas.h"

#include <algorithm>
#include <atomic>

#include "base/stopwatch.h"
#include "field/leaf_values.h"
#include "march/grids.h"
#include "plan/plan.h"

namespace psivox {
namespace {

/// Numbers the uploads: each is one session's atlas with one texel type and one filter.
std::uint64_t next_upload() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

/// Whether nothing else than its own bricks is made of the density's values from now on.
bool only_bricks_need(const Medium& medium) {
  return may_discard(*medium.density) && !medium.light && !medium.lit &&
         std::ranges::count(fields_of(medium), medium.density.get()) == 1;
}

}  // namespace

void WholeAtlas::restore() {
  for (const auto& field : gone_)
    if (field->origin) restore_leaves(*field);  // else it is light
  gone_.clear();
  clear();
}

void WholeAtlas::discard(const std::shared_ptr<const Field>& field) {
  if (std::ranges::count(gone_, field)) return;
  gone_.push_back(field);
  discard_leaves(*field, 0, field->leaves.size());
}

void WholeAtlas::discard_density(const Medium& medium) {
  if (discards && may_discard(*medium.density)) discard(medium.density);
}

void WholeAtlas::discard_fields(const Medium& medium) {
  discard_density(medium);
  if (discards && medium.luminance && (medium.lit || may_discard(*medium.luminance)))
    discard(medium.luminance);
}

void WholeAtlas::clear() {
  coded_.reset();
  atlas_.reset();
  uploads_.clear();
  texels_are_gone_ = false;
}

const MediumAtlas& WholeAtlas::of(const View& view, PreparationTimes& times) {
  if (atlas_) return *atlas_;
  const Stopwatch watch;
  const bool discarding = discards && only_bricks_need(view.medium);
  if (discarding) gone_.push_back(view.medium.density);
  atlas_ = build_medium_atlas(view, discarding);
  times.atlas_ms += watch.ms();
  return *atlas_;
}

const MediumAtlas& WholeAtlas::on_device(const View& view, TexelType texel, const CodeWidths& codes,
                                         PreparationTimes& times, bool last) {
  const MediumAtlas& atlas = of(view, times);
  const CodeWidths widths = codes ? codes : fixed_widths(atlas, texel);
  if (!widths) return atlas;
  if (coded_ && *coded_->widths == *widths) return coded_->atlas;
  const Stopwatch watch;
  coded_.reset();  // before the next take memory
  coded_ = {widths, coded(atlas, *widths, last), next_upload()};
  times.atlas_ms += watch.ms();
  return coded_->atlas;
}

const MediumAtlas& WholeAtlas::upload(Marcher& marcher, const View& view, TexelType texel,
                                      Filter filter, PreparationTimes& times,
                                      const CodeWidths& codes, bool last) {
  const MediumAtlas& wanted = on_device(view, texel, codes, times, last);
  std::uint64_t& number = wanted.density.codes ? coded_->number : uploads_[filter];
  if (number == 0 || marcher.holds != number) {
    marcher.holds = 0;
    marcher.upload(wanted, filter);
    if (number == 0) number = next_upload();
    marcher.holds = number;
  }
  marcher.may_discard = last;
  texels_are_gone_ = texels_are_gone_ || last;
  if (last && wanted.density.codes) {
    atlas_->density.texels.reset();
    if (atlas_->paired) atlas_->luminance->texels.reset();
  }
  return wanted;
}

void WholeAtlas::relight(const View& view) {
  coded_.reset();
  if (atlas_) {
    if (discards) gone_.push_back(view.medium.luminance);
    add_luminance(*atlas_, view, discards);
  }
  uploads_.clear();
}

}  // namespace psivox
