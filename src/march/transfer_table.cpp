#include "march/transfer_table.h"

#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <utility>

#include "march/shader_math.h"

namespace psivox {
SegmentView view_segment(double x_front, double x_back) {
  glsl::Math math;
  const glsl::Math::Decay through = math.decay(0.5 * (x_front + x_back));
  if (!(through.a > 0)) return {};
  return {through.a, math.linear_psi(x_front, x_back, through.e).back / through.a};
}

TransferLattice::TransferLattice(const TransferFunction& function, double first, double last,
                                 int intervals)
    : integrals_(std::size_t(intervals)) {
  const std::vector<TransferPoint>& points = function.points();
  const double spacing = (last - first) / intervals;
  auto next = std::ranges::upper_bound(points, first, {}, &TransferPoint::value);
  TransferPoint from = function.at(first);
  for (int i = 0; i < intervals; ++i) {
    first_piece_.push_back(int(pieces_.size()));
    const double top = i + 1 == intervals ? last : first + spacing * (i + 1);
    Integral& integral = integrals_[std::size_t(i)];
    while (from.value < top) {
      const bool knot = next != points.end() && next->value < top;
      const TransferPoint to = knot ? *next++ : function.at(top);
      const double share = spacing > 0 ? (to.value - from.value) / spacing : 0;
      pieces_.push_back({share, {from.attenuation, to.attenuation}, {from.color, to.color}});
      integral.attenuation += share * 0.5 * (from.attenuation + to.attenuation);
      integral.source += (from.color * (2 * from.attenuation + to.attenuation) +
                          to.color * (from.attenuation + 2 * to.attenuation)) *
                         (share / 6);
      from = to;
    }
    if (next != points.end() && next->value == top) ++next;
  }
  first_piece_.push_back(int(pieces_.size()));
}

TransferRun TransferLattice::run(int interval, double length) const {
  TransferSpan sum;
  for (int i = first_piece_[std::size_t(interval)]; i < first_piece_[std::size_t(interval) + 1];
       ++i) {
    const Piece& p = pieces_[std::size_t(i)];
    const double x[] = {p.attenuation[0] * p.share * length, p.attenuation[1] * p.share * length};
    const SegmentView up = view_segment(x[0], x[1]), down = view_segment(x[1], x[0]);
    TransferSpan piece;
    piece.opacity = up.opacity;
    piece.up = glm::mix(p.color[0], p.color[1], up.back) * up.opacity;
    piece.down = glm::mix(p.color[1], p.color[0], down.back) * up.opacity;
    sum = join(sum, piece);
  }
  if (!(sum.opacity > 0)) return {};
  return {float(sum.opacity), sum.up / sum.opacity, sum.down / sum.opacity};
}

GradientEntries make_gradient_entries(const TransferFunction& function) {
  const GradientPart& part = function.gradient_part();
  const std::vector<TransferPoint>& points = function.points();
  std::vector<double> gradients = part.gradients;
  while (gradients.size() < 2) gradients.push_back(gradients.empty() ? 0 : gradients[0] + 1);
  GradientEntries result;
  result.columns = int(gradients.size()) - 1;
  result.isosurfaces = int(part.isosurfaces.size());
  result.search_steps = std::bit_width(unsigned(result.columns - 1));
  const auto columns = std::size_t(result.columns);
  for (std::size_t j = 0; j < columns; ++j)
    result.entries.emplace_back(gradients[j], gradients[j + 1], 0, 0);
  // beyond the last entry the last one counts
  const std::size_t stored = part.gradients.size();
  const auto at = [&](std::size_t k, std::size_t j) {
    k = std::min(k, points.size() - 1);
    return stored == 0 ? points[k].attenuation
                       : part.attenuation[k * stored + std::min(j, stored - 1)];
  };
  for (std::size_t k = 0; k < std::max<std::size_t>(points.size() - 1, 1); ++k)
    for (std::size_t j = 0; j < columns; ++j)
      result.entries.emplace_back(at(k, j), at(k, j + 1), at(k + 1, j), at(k + 1, j + 1));
  for (const Isosurface& surface : part.isosurfaces)
    result.entries.emplace_back(surface.value, surface.thickness, surface.attenuation, 0);
  return result;
}

TransferTable make_transfer_table(const TransferFunction& function) {
  std::vector<TransferPoint> points = function.points();
  if (points.size() == 1) {  // an interval to be in
    points.push_back(points[0]);
    points[1].value = std::nextafter(float(points[0].value), INFINITY);
  }
  TransferTable table;
  table.knots = int(points.size());
  const double range = points.back().value - points.front().value;
  double integral = 0;  // over the range, or float32 would not hold it where values are great
  glm::dvec3 color_integral{0};
  for (std::size_t k = 0; k < points.size(); ++k) {
    const TransferPoint& p = points[k];
    const TransferPoint& q = points[std::min(k + 1, points.size() - 1)];
    const glm::vec4 head(p.value, p.attenuation, 0, 0), next(q.value, q.attenuation, 0, 0);
    table.entries.emplace_back(head.x, head.y, next.x - head.x, next.y - head.y);
    table.entries.emplace_back(p.color, integral);
    table.entries.emplace_back(glm::vec3(q.color) - glm::vec3(p.color), 0);
    table.entries.emplace_back(color_integral, 0);
    const double d = (q.value - p.value) / range;
    integral += 0.5 * d * (p.attenuation + q.attenuation);
    color_integral += (p.color * (2 * p.attenuation + q.attenuation) +
                       q.color * (p.attenuation + 2 * q.attenuation)) *
                      (d / 6);
  }

  table.min = points.front().value;
  const auto interval = [&](double value) {
    const auto next = std::ranges::upper_bound(points, value, {}, &TransferPoint::value);
    return std::clamp(int(next - points.begin()) - 1, 0, table.knots - 2);
  };
  // So many bins that none holds two knots, within reason: then nothing is searched.
  constexpr int most_bins = 1 << 14;
  const auto ends = [&](int bin) {
    // A float32 value may land one bin off by rounding.
    return std::pair(interval(table.min + range * (bin - 0.25) / table.bins),
                     interval(table.min + range * (bin + 1.25) / table.bins));
  };
  int widest = 0;
  for (table.bins = std::min(2 * table.knots, most_bins);; table.bins *= 2) {
    widest = 1;
    for (int bin = 0; bin < table.bins; ++bin)
      widest = std::max(widest, ends(bin).second - ends(bin).first + 1);
    if (widest <= 2 || 2 * table.bins > most_bins) break;
  }
  table.bin_scale = table.bins / range;
  for (int bin = 0; bin < table.bins; ++bin) {
    const auto [lo, hi] = ends(bin);
    table.entries.emplace_back(float(lo), float(hi), float(points[std::size_t(hi)].value), 0);
  }
  table.search_steps = widest <= 2 ? 0 : std::bit_width(unsigned(widest - 1));
  return table;
}

std::optional<Ramps> make_ramps(const TransferFunction& function) {
  if (function.has_gradient()) return {};
  const std::vector<TransferPoint>& points = function.points();
  // a sum loses as many units of float32 as its terms are times the attenuation
  constexpr double most_cancelling = 16;
  const double most = points.back().attenuation;
  Ramps ramps{.base = points.front().attenuation};
  double slope = 0;
  int count = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    double next = 0;
    if (k + 1 < points.size())
      next = (points[k + 1].attenuation - points[k].attenuation) /
             (points[k + 1].value - points[k].value);
    const double reach = points.back().value - points[k].value;
    if (next < 0 || next * reach > most_cancelling * most) return {};
    if (next == slope) continue;
    if (count == 4) return {};
    ramps.knots[count] = points[k].value;
    ramps.slopes[count] = next - slope;
    slope = next;
    ++count;
  }
  return ramps;
}

}  // namespace psivox
