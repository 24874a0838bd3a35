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

double WholeAtlas::bytes() const {
  double bytes = 0;
  for (const auto& [texel, atlas] : atlases_) bytes += double(atlas.size().bytes());
  return bytes;
}

void WholeAtlas::clear() {
  coded_.reset();
  atlases_.clear();
  uploads_.clear();
  texels_are_gone_ = false;
}

const MediumAtlas& WholeAtlas::of(const View& view, TexelType texel, PreparationTimes& times) {
  texel = host_texel(texel);
  const auto found = atlases_.find(texel);
  if (found != atlases_.end()) return found->second;
  const Stopwatch watch;
  View converted = view;
  converted.scene.texel = texel;
  const bool discarding = discards && only_bricks_need(view.medium);
  if (discarding) gone_.push_back(view.medium.density);
  const MediumAtlas& built =
      atlases_.emplace(texel, build_medium_atlas(converted, discarding)).first->second;
  times.atlas_ms += watch.ms();
  return built;
}

const MediumAtlas& WholeAtlas::on_device(const View& view, TexelType texel, const CodeWidths& codes,
                                         PreparationTimes& times, bool last) {
  const MediumAtlas& atlas = of(view, texel, times);
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
  std::uint64_t& number =
      wanted.density.codes ? coded_->number : uploads_[{host_texel(texel), filter}];
  if (number == 0 || marcher.holds != number) {
    marcher.holds = 0;
    marcher.upload(wanted, filter);
    if (number == 0) number = next_upload();
    marcher.holds = number;
  }
  marcher.may_discard = last;
  texels_are_gone_ = texels_are_gone_ || last;
  if (last && wanted.density.codes)
    for (auto& [type, atlas] : atlases_) {
      atlas.density.texels32.reset();
      if (atlas.paired) atlas.luminance->texels32.reset();
    }
  return wanted;
}

void WholeAtlas::relight(const View& view) {
  coded_.reset();
  View shining = view;
  const bool discarding = discards && atlases_.size() == 1;
  if (discarding) gone_.push_back(view.medium.luminance);
  for (auto& [texel, lit] : atlases_) {
    shining.scene.texel = texel;
    add_luminance(lit, shining, discarding);
  }
  uploads_.clear();
}

}  // namespace psivox
