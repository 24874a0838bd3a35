#include "march/transfer_table.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace psivox {

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
  // of what is missing the last there is
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
  double integral = 0;
  glm::dvec3 color_integral{0};
  for (std::size_t k = 0; k < points.size(); ++k) {
    const TransferPoint& p = points[k];
    const TransferPoint& q = points[std::min(k + 1, points.size() - 1)];
    const glm::vec4 head(p.value, p.attenuation, 0, 0), next(q.value, q.attenuation, 0, 0);
    table.entries.emplace_back(head.x, head.y, next.x - head.x, next.y - head.y);
    table.entries.emplace_back(p.color, integral);
    table.entries.emplace_back(glm::vec3(q.color) - glm::vec3(p.color), 0);
    table.entries.emplace_back(color_integral, 0);
    const double d = q.value - p.value;
    integral += 0.5 * d * (p.attenuation + q.attenuation);
    color_integral += (p.color * (2 * p.attenuation + q.attenuation) +
                       q.color * (p.attenuation + 2 * q.attenuation)) *
                      (d / 6);
  }

  table.min = points.front().value;
  const double range = points.back().value - points.front().value;
  const auto interval = [&](double value) {
    const auto next =
        std::upper_bound(points.begin(), points.end(), value,
                         [](double v, const TransferPoint& p) { return v < p.value; });
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
  // a sum of what is this many times the attenuation loses as many units of float32
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
