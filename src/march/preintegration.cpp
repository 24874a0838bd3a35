#include "march/preintegration.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <iterator>
#include <mutex>
#include <utility>

namespace psivox {
namespace {

/// Layers for segments of lengths up to one of this depth at the function's greatest attenuation,
/// and the values along an axis at most: a million entries each, 16 MiB, and 28 MiB of runs. Thin
/// segments need no layers, thick ones need them more than values: docs/method.md has the bounds.
int layers_for(double depth) { return depth <= 1 ? 1 : depth <= 8 ? 4 : 16; }
int largest_size(int layers) { return layers == 1 ? 1025 : layers <= 4 ? 513 : 257; }

/// Values for the function's detail: a whole number of lattice intervals in its narrowest one,
/// jumps aside, so that the knots of evenly spread ones lie on the lattice.
int size_for(const TransferFunction& function, int largest) {
  const std::vector<TransferPoint>& points = function.points();
  const double range = points.back().value - points.front().value;
  double narrowest = range;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double width = points[i].value - points[i - 1].value;
    if (width * (1 << 16) > range) narrowest = std::min(narrowest, width);
  }
  if (!(narrowest > 0)) return 2;
  const int details = int(std::min(std::round(range / narrowest), double(largest - 1)));
  return details * ((largest - 1) / details) + 1;
}

/// How the shading grows with a segment's optical depth, from x/6 to 1 - 2/x: coth(x/2) - 2/x,
/// which it is for constant attenuation and linear colour, by a rational function.
double saturation(double x) {
  x = std::min(x, 1e100);
  return x * (x + 4) / (x * (x + 6) + 24);
}

glm::dvec3 shading_of(const glm::dvec3& radiance, const TransferSpan& span) {
  if (!(span.opacity > 0) || !(span.attenuation > 0)) return glm::dvec3(0);
  return radiance / span.opacity - span.source / span.attenuation;
}

}  // namespace

PreintegratedTable::PreintegratedTable(const TransferFunction& function, double extinction,
                                       double max_length, const Shape& shape)
    : function_(function), extinction_(extinction), max_length_(max_length), shape_(shape) {
  build();
}

int PreintegratedTable::size_of(const TransferFunction& function) const {
  return shape_.size ? shape_.size : size_for(function, largest_size(shape_.layers));
}

void PreintegratedTable::build() {
  const std::vector<TransferPoint>& points = function_.points();
  first_ = points.front().value;
  last_ = points.back().value;
  layers_ = shape_.layers;
  size_ = size_of(function_);
  scale_ = last_ > first_ ? (size_ - 1) / (last_ - first_) : 0;
  lattice_.emplace(function_, first_, last_, size_ - 1);
  const int widths = size_ - 1;
  const auto count = std::size_t(layers_) * std::size_t(size_);
  runs_.resize(std::size_t(layers_) * std::size_t(widths) * std::size_t(widths));
  entries_.assign(count * std::size_t(size_), glm::vec4(0));
  compute(0, widths - 1);
}

/// Computes the runs of the intervals from lo to hi, and the entries of spans that have one of
/// them.
void PreintegratedTable::compute(int lo, int hi) {
  const int widths = size_ - 1;
  tbb::parallel_for(tbb::blocked_range<int>(0, layers_ * widths, 4), [&](const auto& range) {
    for (int k = range.begin(); k < range.end(); ++k) {
      const int layer = k / widths, width = k % widths + 1;
      const double length = extinction_ * length_at(layer + 1) / width;
      TransferRun* const runs =
          runs_.data() + std::size_t(layer * widths + width - 1) * std::size_t(widths);
      for (int i = lo; i <= hi; ++i) runs[i] = lattice_->run(i, length);
      glm::vec4* up = entries_.data() + std::size_t(layer * size_ + width) * std::size_t(size_);
      glm::vec4* down =
          entries_.data() + std::size_t(layer * size_ + size_ - width) * std::size_t(size_) + width;
      lattice_->spans(runs, width, std::max(0, lo - width + 1), std::min(hi, widths - width),
                      [&](int i, const TransferSpan& span) {
                        up[i] = glm::vec4(shading_of(span.up, span), 0);
                        down[i] = glm::vec4(shading_of(span.down, span), 0);
                      });
    }
  });
}

bool PreintegratedTable::update(const TransferFunction& changed) {
  const std::vector<TransferPoint> old = std::exchange(function_, changed).points();
  const std::vector<TransferPoint>& now = function_.points();
  if (now.front().value != first_ || now.back().value != last_ || size_of(function_) != size_) {
    build();
    return false;
  }
  const auto head = std::mismatch(old.begin(), old.end(), now.begin(), now.end()).first;
  if (head == old.end() && old.size() == now.size()) return true;
  // the common ends may not overlap, where points were left out or put in
  const auto most = std::ptrdiff_t(std::min(old.size(), now.size())) - (head - old.begin());
  const auto tail =
      std::mismatch(old.rbegin(), old.rbegin() + most, now.rbegin(), now.rbegin() + most).first;
  const double from = head == old.begin() ? first_ : std::prev(head)->value;
  const double to = tail == old.rbegin() ? last_ : std::prev(tail)->value;
  const int widths = size_ - 1;
  const int lo = std::clamp(int(std::floor((from - first_) * scale_)), 0, widths - 1);
  const int hi = std::clamp(int(std::ceil((to - first_) * scale_)) - 1, lo, widths - 1);

  lattice_.emplace(function_, first_, last_, widths);
  compute(lo, hi);
  return true;
}

/// Linear on triangles whose long sides run along diagonals: exactly 0 for equal ends.
glm::dvec3 PreintegratedTable::shading(double front, double back, double length,
                                       double mean_attenuation) const {
  const double x = std::clamp((front - first_) * scale_, 0.0, size_ - 1.0);
  const double y = std::clamp((back - first_) * scale_, 0.0, size_ - 1.0);
  const int i = std::min(int(x), size_ - 2), j = std::min(int(y), size_ - 2);
  const double u = x - i, v = y - j;
  const auto entry = [&](int layer, int p, int q) {
    const int diagonal = q < p ? q - p + size_ : q - p;
    return glm::dvec3(entries_[std::size_t((layer * size_ + diagonal) * size_ + p)]);
  };
  const auto at = [&](int layer) {
    if (layer < 0) return glm::dvec3(0);
    return entry(layer, i, j) * (1 - std::max(u, v)) + entry(layer, i + 1, j + 1) * std::min(u, v) +
           (u < v ? entry(layer, i, j + 1) : entry(layer, i + 1, j)) * std::abs(u - v);
  };
  const int layer = std::min(int(layers_ * std::sqrt(length / max_length_)), layers_ - 1);
  const double depth = extinction_ * mean_attenuation;
  const double from = saturation(depth * length_at(layer));
  const double to = saturation(depth * length_at(layer + 1));
  const double w = (saturation(depth * length) - from) / std::max(to - from, 1e-30);
  return glm::mix(at(layer - 1), at(layer), std::clamp(w, 0.0, 1.0));
}

double PreintegratedTable::error_bound() const {
  const int fine = 4 * (size_ - 1);
  const TransferLattice lattice(function_, first_, last_, fine);
  const auto value = [&](int i) { return first_ + (last_ - first_) * i / fine; };
  std::vector<int> widths;
  for (int w = 1; w <= fine; w += 1 + w / 8) widths.push_back(w);
  const int quarters = 4 * layers_;
  const double largest = tbb::parallel_reduce(
      tbb::blocked_range<int>(0, quarters * int(widths.size()), 1), 0.0,
      [&](const auto& range, double most) {
        std::vector<TransferRun> runs(static_cast<std::size_t>(fine));
        for (int k = range.begin(); k < range.end(); ++k) {
          const int width = widths[std::size_t(k / quarters)];
          const double length = length_at(0.25 * (k % quarters + 1));
          for (int i = 0; i < fine; ++i)
            runs[std::size_t(i)] = lattice.run(i, extinction_ * length / width);
          lattice.spans(runs.data(), width, 0, fine - width, [&](int i, const TransferSpan& span) {
            const double lower = value(i), upper = value(i + width);
            const double mean = span.attenuation / width;
            const glm::dvec3 up = shading(lower, upper, length, mean) - shading_of(span.up, span);
            const glm::dvec3 down =
                shading(upper, lower, length, mean) - shading_of(span.down, span);
            const glm::dvec3 d = glm::max(glm::abs(up), glm::abs(down));
            most = std::max(most, span.opacity * std::max({d.x, d.y, d.z}));
          });
        }
        return most;
      },
      [](double a, double b) { return std::max(a, b); });
  return 2 * largest;
}

std::shared_ptr<const PreintegratedTable> preintegrated_table(const TransferFunction& function,
                                                              double extinction, double max_length,
                                                              bool constant_length,
                                                              bool may_update) {
  static std::mutex mutex;
  static std::shared_ptr<PreintegratedTable> last;
  static bool last_was_updated = false;
  const std::lock_guard lock(mutex);
  const std::vector<TransferPoint>& points = function.points();
  const double depth =
      extinction * max_length * function.max_attenuation(points.front().value, points.back().value);
  const int layers = constant_length ? 1 : layers_for(depth);
  const bool same_shape = last && last->extinction() == extinction &&
                          last->max_length() == max_length && last->layers() == layers;
  if (same_shape && last->function() == function && (may_update || !last_was_updated)) return last;
  if (same_shape && may_update) {
    if (last.use_count() > 1) last = std::make_shared<PreintegratedTable>(*last);
    last_was_updated = last->update(function);
  } else {
    last = std::make_shared<PreintegratedTable>(function, extinction, max_length,
                                                PreintegratedTable::Shape{0, layers});
    last_was_updated = false;
  }
  return last;
}

}  // namespace psivox
