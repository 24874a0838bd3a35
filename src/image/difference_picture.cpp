#include <algorithm>
#include <cmath>
#include <vector>

#include "psivox/colormap.h"
#include "psivox/image.h"
#include "psivox/statistics.h"

namespace psivox {
namespace {

/// Of the differences of R, G and B the largest in magnitude, with its sign.
double largest_difference(const float* a, const float* b) {
  double largest = 0;
  for (int c = 0; c < 3; ++c) {
    const double d = double(a[c]) - double(b[c]);
    if (std::abs(d) > std::abs(largest)) largest = d;
  }
  return largest;
}

}  // namespace

double difference_scale(const Image& a, const Image& b) {
  std::vector<double> differences;
  double most = 0;
  for (std::size_t i = 0; i < a.rgba().size(); i += 4) {
    const double d = std::abs(largest_difference(&a.rgba()[i], &b.rgba()[i]));
    if (!std::isfinite(d)) continue;
    differences.push_back(d);
    most = std::max(most, d);
  }
  const double scale = percentile(std::move(differences), 0.99);
  return scale > 0 ? scale : most;
}

Image difference_picture(const Image& a, const Image& b, double scale) {
  Image out;
  out.width = a.width;
  out.height = a.height;
  out.layers.push_back({"", {"R", "G", "B", "A"}, std::vector<float>(a.rgba().size(), 1.0f)});
  for (std::size_t i = 0; i < a.rgba().size(); i += 4) {
    const double largest = largest_difference(&a.rgba()[i], &b.rgba()[i]);
    const glm::dvec3 color =
        colormap_color(Colormap::coolwarm, scale > 0 ? 0.5 + 0.5 * largest / scale : 0.5);
    for (int c = 0; c < 3; ++c) out.rgba()[i + std::size_t(c)] = float(color[c]);
  }
  return out;
}

}  // namespace psivox
