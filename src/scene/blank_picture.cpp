// Why a picture shows nothing.

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "psivox/medium.h"
#include "psivox/subject.h"
#include "psivox/text.h"
#include "scene/isovalue.h"
#include "scene/value_range.h"

namespace psivox {
namespace {

std::string text_of(const glm::dvec3& v) { return formatted("%.4g,%.4g,%.4g", v.x, v.y, v.z); }
std::string text_of(const glm::dvec2& v) { return formatted("%.4g to %.4g", v.x, v.y); }

bool meets_box(const WorldRay& ray, const View& view) {
  double near = view.camera.orthographic ? -std::numeric_limits<double>::infinity() : 0;
  double far = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (view.subject->box_min[axis] - ray.origin[axis]) / ray.direction[axis];
    const double b = (view.subject->box_max[axis] - ray.origin[axis]) / ray.direction[axis];
    if (std::isnan(a) || std::isnan(b)) continue;  // along a face
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near <= far;
}

/// Tries 64 x 64 rays.
bool camera_sees_box(const View& view) {
  const glm::ivec2 size = view.scene.resolution;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      if (meets_box(camera_ray(view.camera, size, (x + 0.5) / 64 * size.x, (y + 0.5) / 64 * size.y),
                    view))
        return true;
  return false;
}

/// Why nothing is on the rays through the volume; empty if something is.
std::string why_empty(const View& view) {
  const Medium& medium = view.medium;
  const Scene& scene = view.scene;
  const Field& density = *medium.density;
  const std::string grid = "grid " + in_quotes(density.name);
  const glm::dvec2 values = stored_range(density);
  if (scene.mode == Mode::isosurface) {
    const double isovalue = scene.isovalue.value_or(0);
    const double of_field = field_isovalue(isovalue, density);
    if (of_field >= values.x && of_field <= values.y) return {};
    return "--isovalue " + formatted("%.4g", isovalue) + " is not among the values of " + grid +
           ", which go from " + text_of(values);
  }
  if (medium.emission || scene.mode == Mode::slice) return {};
  if (scene.attenuates() && medium.extinction == 0) return "--extinction is 0";
  const bool attenuates = medium.transfer
                              ? medium.transfer->max_attenuation(
                                    values, {0, std::numeric_limits<double>::infinity()}) > 0
                              : values.y > 0;
  if (attenuates) return {};
  if (!medium.transfer) return grid + " has no value above 0";
  return "no value of " + grid + ", which go from " + text_of(values) +
         ", has an attenuation above 0 by " +
         (scene.transfer_function.empty() ? "--range and --opacity" : "--transfer-function");
}

/// Why what is on the rays gives no light; empty if it might.
std::string why_dark(const View& view) {
  const Scene& scene = view.scene;
  if (scene.mode == Mode::isosurface || !scene.composites()) return {};
  if (!scene.temperature_grid.empty())
    return "nothing in grid " + in_quotes(scene.temperature_grid) +
           " is hot enough to glow; --temperature-scale gives Kelvin per unit of its values";
  if (scene.lit() && scene.albedo == 0) return "--albedo is 0";
  if (!scene.lit() && scene.resolved_luminance() == glm::dvec3(0)) return "--luminance is 0";
  if (!scene.luminance_grid.empty())
    return "grid " + in_quotes(scene.luminance_grid) + ", the luminance, is 0 where it is seen";
  return {};
}

}  // namespace

std::string blank_reason(const View& view, const Image& image) {
  // Half an sRGB code of 8 bits; less is black on a display.
  constexpr double least = 0.5 / 255 / 12.92;
  double light = 0, opacity = 0;
  const auto rgba = image.rgba();
  for (std::size_t i = 0; i < rgba.size(); ++i)
    (i % 4 == 3 ? opacity : light) = std::max(i % 4 == 3 ? opacity : light, double(rgba[i]));
  const double factor = std::exp2(view.scene.exposure.value_or(0));
  if (light * factor > least || (light > 0 && !view.scene.exposure)) return {};

  const std::string what = opacity > least ? "the picture is black: " : "the picture is empty: ";
  if (opacity <= least && !camera_sees_box(view))
    return what + "the camera looks past the volume, which lies from " +
           text_of(view.subject->box_min) + " to " + text_of(view.subject->box_max) +
           "; leave out the camera's options, or give --camera-target " +
           text_of(glm::mix(view.subject->box_min, view.subject->box_max, 0.5));
  std::string why = opacity > least ? std::string() : why_empty(view);
  if (why.empty()) why = why_dark(view);
  if (why.empty() && light > 0)
    why = "its brightest light is " + formatted("%.2g", light) + "; --exposure auto shows it";
  if (why.empty()) why = "no ray meets anything that attenuates or glows";
  return what + why;
}

}  // namespace psivox
