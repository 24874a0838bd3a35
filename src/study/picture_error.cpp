#include "study/picture_error.h"

#include <cmath>
#include <utility>
#include <vector>

#include "psivox/error.h"
#include "psivox/statistics.h"

namespace psivox {
namespace {

/// Channels first to last - 1 of both pictures.
Deviation deviation(const Image& a, const Image& b, std::size_t first, std::size_t last) {
  Deviation d;
  std::vector<double> absolute;
  double sum = 0, squares = 0;
  const std::size_t pixels = a.rgba().size() / 4;
  absolute.reserve(pixels * (last - first));
  for (std::size_t i = 0; i < pixels; ++i)
    for (std::size_t c = first; c < last; ++c) {
      const double value = double(a.rgba()[4 * i + c]) - double(b.rgba()[4 * i + c]);
      if (!std::isfinite(value)) {
        ++d.not_finite;
        continue;
      }
      sum += value;
      squares += value * value;
      absolute.push_back(std::abs(value));
      if (absolute.back() <= d.max) continue;
      d.max = absolute.back();
      d.max_x = int(i % std::size_t(a.width));
      d.max_y = int(i / std::size_t(a.width));
    }
  if (absolute.empty()) return d;
  d.rms = std::sqrt(squares / double(absolute.size()));
  d.mean = sum / double(absolute.size());
  d.p99 = percentile(std::move(absolute), 0.99);
  return d;
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

}  // namespace psivox
