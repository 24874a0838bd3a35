#include "study/picture_error.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "psivox/error.h"
#include "psivox/statistics.h"

namespace psivox {
namespace {

/// The deviation of a - b in the channels from `first` to `last` - 1.
Deviation deviation(const Image& a, const Image& b, std::size_t first, std::size_t last) {
  ErrorSum sum;
  std::vector<double> absolute;
  std::uint64_t not_finite = 0;
  const std::size_t pixels = a.rgba().size() / 4, width = std::size_t(a.width);
  absolute.reserve(pixels * (last - first));
  for (std::size_t i = 0; i < pixels; ++i)
    for (std::size_t c = first; c < last; ++c) {
      const double value = double(a.rgba()[4 * i + c]) - double(b.rgba()[4 * i + c]);
      if (!std::isfinite(value)) {
        ++not_finite;
        continue;
      }
      sum.add(value, i);
      absolute.push_back(std::abs(value));
    }
  return {.rms = sum.rms(),
          .max = sum.max,
          .max_x = int(sum.max_at % width),
          .max_y = int(sum.max_at / width),
          .p99 = percentile(std::move(absolute), 0.99),
          .mean = sum.mean(),
          .not_finite = not_finite};
}

}  // namespace

double PictureError::rms() const {
  return std::sqrt((3 * radiance.rms * radiance.rms + alpha.rms * alpha.rms) / 4);
}

PictureError picture_error(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height)
    throw Error(ExitCode::input, "pictures of different sizes cannot be compared");
  return {deviation(a, b, 0, 3), deviation(a, b, 3, 4)};
}

double rounding_rms(const Image& image) {
  ErrorSum sum;
  for (const float value : image.rgba())
    if (std::isfinite(value)) sum.add(value, 0);
  return 8.0 * std::numeric_limits<float>::epsilon() * sum.rms();
}

}  // namespace psivox
