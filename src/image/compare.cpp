#include <cassert>
#include <cmath>
#include <string>

#include "psivox/error.h"
#include "psivox/image.h"

namespace psivox {
namespace {

std::string size_text(const Image& image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height);
}

bool all_finite(const float* pixel) {
  return std::isfinite(pixel[0]) && std::isfinite(pixel[1]) && std::isfinite(pixel[2]) &&
         std::isfinite(pixel[3]);
}

}  // namespace

Comparison compare_images(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height) {
    throw Error(ExitCode::input, "pictures of different sizes cannot be compared: " + size_text(a) +
                                     " and " + size_text(b));
  }
  static constexpr std::array<const char*, 4> channel_names = {"R", "G", "B", "A"};
  const auto width = static_cast<std::size_t>(a.width);
  const std::size_t pixels = width * static_cast<std::size_t>(a.height);
  assert(a.rgba().size() == pixels * 4 && b.rgba().size() == pixels * 4);

  Comparison result;
  std::array<double, 4> sum{};
  std::array<double, 4> sum_of_squares{};
  for (std::size_t i = 0; i < pixels; ++i) {
    const float* pixel_a = a.rgba().data() + i * 4;
    const float* pixel_b = b.rgba().data() + i * 4;
    if (!all_finite(pixel_a) || !all_finite(pixel_b)) {
      ++result.not_finite;
      continue;
    }
    for (std::size_t c = 0; c < 4; ++c) {
      const double difference = static_cast<double>(pixel_a[c]) - static_cast<double>(pixel_b[c]);
      sum[c] += difference;
      sum_of_squares[c] += difference * difference;
      if (std::abs(difference) > result.max) {
        result.max = std::abs(difference);
        result.max_x = static_cast<int>(i % width);
        result.max_y = static_cast<int>(i / width);
        result.max_channel = channel_names[c];
      }
    }
  }
  if (pixels == result.not_finite) return result;
  const auto compared = static_cast<double>(pixels - result.not_finite);
  double total = 0;
  for (std::size_t c = 0; c < 4; ++c) {
    result.channel_rms[c] = std::sqrt(sum_of_squares[c] / compared);
    result.channel_mean[c] = sum[c] / compared;
    total += sum_of_squares[c];
  }
  result.rms = std::sqrt(total / (4 * compared));
  return result;
}

}  // namespace psivox
