#include "plan/picture_error.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "plan/pilot.h"
#include "psivox/error.h"
#include "reference/reference.h"

namespace psivox {

std::vector<glm::ivec2> spread_pixels(const glm::ivec2& size, std::size_t count) {
  const std::size_t all = std::size_t(size.x) * std::size_t(size.y);
  count = std::min(count, all);
  std::vector<glm::ivec2> pixels;
  std::vector<bool> seen(all);
  const auto see = [&](const glm::ivec2& pixel) {
    const std::size_t at = std::size_t(pixel.y) * std::size_t(size.x) + std::size_t(pixel.x);
    if (!seen[at] && pixels.size() < count) pixels.push_back(pixel);
    seen[at] = true;
  };
  // powers of 1/p, where p^3 = p + 1: the plane's counterpart of the golden section
  glm::dvec2 at(0.5);
  for (std::size_t i = 0; i < 4 * count; ++i) {
    see(glm::min(glm::ivec2(at * glm::dvec2(size)), size - 1));
    at = glm::fract(at + glm::dvec2(0.7548776662466927, 0.5698402909980532));
  }
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) see({x, y});
  return pixels;
}

glm::dvec4 seen_error(const Image& truth, const Backdrop& behind, std::size_t pixel,
                      const float* rgba) {
  glm::dvec4 difference;
  for (int c = 0; c < 4; ++c)
    difference[c] = double(rgba[c]) - double(truth.rgba()[4 * pixel + std::size_t(c)]);
  return behind.seen(difference, pixel);
}

CheckedError exact_error(const View& exact, const Image& drawn) {
  return check_pixels(pilot_view(exact), drawn, drawn.width * drawn.height);
}

ErrorSum seen_errors(const Image& picture, const Image& truth, const Backdrop& behind) {
  if (picture.width != truth.width || picture.height != truth.height)
    throw Error(ExitCode::failure, "pictures of different sizes have no error");
  ErrorSum errors;
  for (std::size_t i = 0; i < truth.pixels(); ++i) {
    const glm::dvec4 difference = seen_error(truth, behind, i, &picture.rgba()[4 * i]);
    for (int c = 0; c < 4; ++c) errors.add(difference[c], i);
  }
  return errors;
}

Layer error_layer(const Image& picture, const Image& better, const Backdrop& behind,
                  double common) {
  Layer layer{"error", {"error"}, {}};
  layer.values.reserve(picture.pixels());
  for (std::size_t i = 0; i < picture.pixels(); ++i) {
    const double rms = glm::length(seen_error(better, behind, i, &picture.rgba()[4 * i])) / 2;
    layer.values.push_back(float(std::hypot(rms, common)));
  }
  return layer;
}

std::vector<WorldRay> checked_rays(const View& view, const Image& picture, int pixels) {
  const glm::ivec2 size(picture.width, picture.height);
  std::vector<WorldRay> rays;
  for (const glm::ivec2& place : spread_pixels(size, std::size_t(pixels)))
    for (int i = 0; i < view.scene.pixel_samples; ++i) {
      const glm::dvec2 at = glm::dvec2(place) + pixel_sample(i, view.scene.pixel_samples);
      rays.push_back(camera_ray(view.camera, size, at.x, at.y));
    }
  return rays;
}

CheckedError check_pixels(const View& view, const Image& picture, int pixels,
                          const Progress& progress) {
  const std::vector<glm::ivec2> places =
      spread_pixels({picture.width, picture.height}, std::size_t(pixels));
  const std::vector<glm::dvec4> truth = reference_pixels(view, places, 1e-12, progress);
  CheckedError error{int(places.size())};
  ErrorSum sum;
  const Backdrop behind(view);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto at = picture.index(places[i].x, places[i].y);
    glm::dvec4 drawn;
    for (int c = 0; c < 4; ++c) drawn[c] = double(picture.rgba()[4 * at + std::size_t(c)]);
    const glm::dvec4 difference = behind.seen(drawn - truth[i], at);
    for (int c = 0; c < 4; ++c) sum.add(difference[c], i);
  }
  error.rms = sum.rms();
  error.max = sum.max;
  error.max_x = places[sum.max_at].x;
  error.max_y = places[sum.max_at].y;
  return error;
}

}  // namespace psivox
