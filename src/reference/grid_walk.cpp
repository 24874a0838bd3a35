#include "grid_walk.h"
#include "limits.h"

#include <algorithm>

namespace psivox {
namespace {

constexpr std::size_t cells_level = FieldLookup::widths.size();

}  // namespace

GridWalk::GridWalk(const FieldLookup& lookup, BlockCache& cache, const IndexRay& ray)
    : lookup_(&lookup),
      cache_(&cache),
      ray_(ray),
      begin_(-infinity),
      end_(ray.hits() ? ray.s_begin : infinity) {}

void GridWalk::next() {
  if (steps_[0])
    steps_[level_]->next();
  else
    steps_[0].emplace(ray_, FieldLookup::widths[0], ray_.s_begin, ray_.s_end);
  find();
}

/// Goes from the current steps to the next stretch that has a length.
void GridWalk::find() {
  while (true) {
    const CubeSteps& steps = *steps_[level_];
    if (steps.done()) {
      if (level_ == 0) return enter_zeros(ray_.s_end, infinity, false);
      steps_[--level_]->next();
      continue;
    }
    if (!(steps.begin() < steps.end())) {
      steps_[level_]->next();
      continue;
    }
    if (level_ == cells_level) return enter_cell(steps);
    bool empty = !lookup_->may_hold_values(static_cast<int>(level_), steps.key());
    if (!empty && level_ + 1 == cells_level) {
      block_ = &cache_->at(steps.key());
      empty = block_->empty;
    }
    if (empty) return enter_zeros(steps.begin(), steps.end(), true);
    const int width = level_ + 1 == cells_level ? 1 : FieldLookup::widths[level_ + 1];
    steps_[level_ + 1].emplace(ray_, width, steps.begin(), steps.end());
    ++level_;
  }
}

void GridWalk::enter_zeros(double begin, double end, bool in_domain) {
  begin_ = begin;
  end_ = end;
  in_domain_ = in_domain;
  block_ = nullptr;
  low_ = high_ = {};
}

void GridWalk::enter_cell(const CubeSteps& steps) {
  begin_ = steps.begin();
  end_ = steps.end();
  in_domain_ = true;
  cell_ = steps.key();
  for (int c = 0; c < block_->channels; ++c) {
    const auto i = static_cast<std::size_t>(c);
    corners_[i] = block_->corners(cell_, c);
    const auto [low, high] = std::minmax_element(corners_[i].begin(), corners_[i].end());
    low_[i] = *low;
    high_[i] = *high;
  }
}

bool GridWalk::all_zero() const {
  return low_ == std::array<double, 3>{} && high_ == std::array<double, 3>{};
}

// Coefficients are means of the field in the cell; rounding must not leave its corners' range, so
// that a cell of one value is exactly that.
Cubic GridWalk::along(double a, double b, int channel) const {
  if (!block_) return {};
  Cubic c = cubic_along(corners(channel), ray_.in_cell(cell_, a), ray_.in_cell(cell_, b));
  for (double& v : c) v = std::clamp(v, low(channel), high(channel));
  return c;
}

}  // namespace psivox
