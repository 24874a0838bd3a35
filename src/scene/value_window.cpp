#include "scene/value_window.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace psivox {
namespace {

class Window {
 public:
  Window(const Scene& scene, const glm::dvec2& range) : scene_(scene), range_(range) {}

  double place(double value) const { return (value - range_.x) / (range_.y - range_.x); }

  double attenuation(double value) const {
    const double u = place(value);
    if (scene_.opacity) return scene_.opacity->at(u);
    if (scene_.colormap) return std::max(value, 0.0);
    return scene_.shows(Shows::value) ? std::max(u, 0.0) : std::clamp(u, 0.0, 1.0);
  }

  glm::dvec3 color(double value) const {
    const double u = place(value);
    if (scene_.colormap) return colormap_color(*scene_.colormap, u);
    return glm::dvec3(scene_.shows(Shows::value) ? std::max(u, 0.0) : 1);
  }

  /// Values at which attenuation or colour bend.
  std::vector<double> knots() const {
    std::vector<double> values = {0, range_.x, range_.y};
    const auto add = [&](double u) { values.push_back(std::lerp(range_.x, range_.y, u)); };
    if (scene_.opacity)
      for (const glm::dvec2& point : scene_.opacity->points) add(point.x);
    if (scene_.colormap)
      for (const double u : colormap_knots(*scene_.colormap)) add(u);
    return values;
  }

 private:
  const Scene& scene_;
  glm::dvec2 range_;
};

}  // namespace

double OpacityCurve::at(double place) const {
  if (points.empty()) return 1;
  const auto above = std::upper_bound(points.begin(), points.end(), place,
                                      [](double u, const glm::dvec2& p) { return u < p.x; });
  if (above == points.begin()) return points.front().y;
  if (above == points.end()) return points.back().y;
  const glm::dvec2 &a = above[-1], &b = *above;
  return std::lerp(a.y, b.y, (place - a.x) / (b.x - a.x));
}

TransferFunction window_function(const Scene& scene, const glm::dvec2& range,
                                 const glm::dvec2& stored) {
  const Window window(scene, range);
  const double least = std::min(stored.x, 0.0), greatest = std::max(stored.y, 0.0);
  std::vector<double> values = {least, greatest};
  for (const double value : window.knots())
    if (value > least && value < greatest) values.push_back(value);
  // Rounded here, so that none becomes a jump of its neighbour.
  for (double& value : values) value = static_cast<double>(static_cast<float>(value));
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  std::vector<TransferPoint> points;
  for (const double value : values)
    points.push_back({value, window.attenuation(value), window.color(value)});
  return TransferFunction(std::move(points), scene.colormap || scene.shows(Shows::value));
}

}  // namespace psivox
