#include <algorithm>
#include <cmath>
#include <random>

#include "draw/plan.h"
#include "psivox/error.h"
#include "psivox/statistics.h"
#include "reference/reference.h"

namespace psivox {
namespace {

/// One pixel in each of about `count` cells of equal size.
std::vector<glm::ivec2> stratified_pixels(const glm::ivec2& size, int count) {
  const double share = std::min(1.0, double(count) / (double(size.x) * double(size.y)));
  const glm::ivec2 cells = glm::max(glm::ivec2(1), glm::ivec2(glm::dvec2(size) * std::sqrt(share)));
  std::mt19937 random(1);
  // std::uniform_int_distribution differs between standard libraries
  const auto pick = [&](int cell, int all, int extent) {
    const int first = int(std::int64_t(cell) * extent / all);
    const int last = int(std::int64_t(cell + 1) * extent / all);
    return first + int(random() % std::uint32_t(std::max(last - first, 1)));
  };
  std::vector<glm::ivec2> pixels;
  for (int y = 0; y < cells.y; ++y)
    for (int x = 0; x < cells.x; ++x) {
      const int at = pick(x, cells.x, size.x);
      pixels.emplace_back(at, pick(y, cells.y, size.y));
    }
  return pixels;
}

}  // namespace

Layer error_layer(const Image& picture, const Image& better, double common) {
  if (picture.width != better.width || picture.height != better.height)
    throw Error(ExitCode::failure, "pictures of different sizes have no error layer");
  Layer layer{"error", {"error"}, {}};
  const auto a = picture.rgba(), b = better.rgba();
  layer.values.reserve(a.size() / 4);
  for (std::size_t i = 0; i < a.size(); i += 4) {
    double squares = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      const double d = double(a[i + c]) - double(b[i + c]);
      squares += d * d;
    }
    layer.values.push_back(float(std::hypot(std::sqrt(squares / 4), common)));
  }
  return layer;
}

CheckedError check_pixels(const View& view, const Image& picture, int pixels,
                          const Progress& progress) {
  const std::vector<glm::ivec2> places = stratified_pixels({picture.width, picture.height}, pixels);
  const std::vector<glm::dvec4> truth = reference_pixels(view, places, 1e-12, progress);
  CheckedError error{int(places.size())};
  ErrorSum sum;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto at =
        std::size_t(places[i].y) * std::size_t(picture.width) + std::size_t(places[i].x);
    for (int c = 0; c < 4; ++c)
      sum.add(double(picture.rgba()[4 * at + std::size_t(c)]) - truth[i][c], i);
  }
  error.rms = sum.rms();
  error.max = sum.max;
  error.max_x = places[sum.max_at].x;
  error.max_y = places[sum.max_at].y;
  return error;
}

}  // namespace psivox
