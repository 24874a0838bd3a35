#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "base/statistics.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "scene/color.h"

namespace psivox {
namespace {

std::string size_text(const Image& image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height);
}

bool all_finite(const float* pixel) {
  return std::isfinite(pixel[0]) && std::isfinite(pixel[1]) && std::isfinite(pixel[2]) &&
         std::isfinite(pixel[3]);
}

/// The difference of R, G or B with the largest magnitude, with its sign.
double largest_difference(const float* a, const float* b) {
  double largest = 0;
  for (int c = 0; c < 3; ++c) {
    const double d = double(a[c]) - double(b[c]);
    if (std::abs(d) > std::abs(largest)) largest = d;
  }
  return largest;
}

}  // namespace

Comparison compare_images(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height) {
    throw Error(ExitCode::input, "pictures of different sizes cannot be compared: " + size_text(a) +
                                     " and " + size_text(b));
  }
  static constexpr std::array<const char*, 4> channel_names = {"R", "G", "B", "A"};
  const auto width = std::size_t(a.width);
  const std::size_t pixels = width * std::size_t(a.height);
  assert(a.rgba().size() == pixels * 4 && b.rgba().size() == pixels * 4);

  Comparison result;
  std::array<ErrorSum, 4> channels;
  for (std::size_t i = 0; i < pixels; ++i) {
    const float* pixel_a = a.rgba().data() + i * 4;
    const float* pixel_b = b.rgba().data() + i * 4;
    if (!all_finite(pixel_a) || !all_finite(pixel_b)) {
      ++result.not_finite;
      continue;
    }
    for (std::size_t c = 0; c < 4; ++c) {
      const double difference = double(pixel_a[c]) - double(pixel_b[c]);
      channels[c].add(difference, i * 4 + c);
    }
  }
  ErrorSum all;
  if (result.not_finite == pixels) {  // nothing is known
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    result.rms = result.max = unknown;
    result.channel_rms.fill(unknown);
    result.channel_mean.fill(unknown);
    return result;
  }
  for (std::size_t c = 0; c < 4; ++c) {
    all += channels[c];
    result.channel_rms[c] = channels[c].rms();
    result.channel_mean[c] = channels[c].mean();
  }
  result.rms = all.rms();
  result.max = all.max;
  result.max_x = int(all.max_at / 4 % width);
  result.max_y = int(all.max_at / 4 / width);
  if (all.max > 0) result.max_channel = channel_names[all.max_at % 4];
  return result;
}

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
  Image out = rgba_image(a.width, a.height, 1);
  for (std::size_t i = 0; i < a.rgba().size(); i += 4) {
    const double largest = largest_difference(&a.rgba()[i], &b.rgba()[i]);
    const glm::dvec3 color =
        colormap_color(Colormap::coolwarm, scale > 0 ? 0.5 + 0.5 * largest / scale : 0.5);
    for (int c = 0; c < 3; ++c) out.rgba()[i + std::size_t(c)] = float(color[c]);
  }
  return out;
}

}  // namespace psivox
