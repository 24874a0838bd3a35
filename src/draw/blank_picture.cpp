// Why a picture shows nothing.

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "base/text.h"
#include "draw/picture.h"
#include "field/index_space.h"
#include "field/lane_range.h"
#include "field/value_range.h"
#include "image/srgb_codes.h"
#include "medium/backdrop.h"
#include "medium/density_function.h"
#include "psivox/camera.h"
#include "psivox/draw.h"
#include "psivox/medium.h"
#include "psivox/parameters.h"
#include "scene/cuts.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

std::string short_text(const glm::dvec3& v) { return formatted("%.4g,%.4g,%.4g", v.x, v.y, v.z); }
std::string short_text(const glm::dvec2& v) { return formatted("%.4g to %.4g", v.x, v.y); }

bool meets_box(const WorldRay& ray, const View& view) {
  const glm::dvec2 inside =
      interval_in(view.subject->box_min, view.subject->box_max, ray.origin, ray.direction);
  return inside.x <= inside.y && (view.camera.orthographic || inside.y >= 0);
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

bool is_in_frame(const glm::dvec3& point, const Camera& camera) {
  const glm::dvec3 way = point - camera.position;
  const double ahead = glm::dot(way, camera.forward), reach = camera.orthographic ? 1 : ahead;
  return ahead > 0 && std::abs(glm::dot(way, camera.right)) <= reach * camera.half_width &&
         std::abs(glm::dot(way, camera.up)) <= reach * camera.half_height;
}

std::string place_of_volume(const View& view) {
  return "the volume, which lies from " + short_text(view.subject->box_min) + " to " +
         short_text(view.subject->box_max);
}

std::string grid_text(const View& view) {
  const Field& density = *view.medium.density;
  return "grid " + in_quotes(density.name) + ", which go from " + short_text(stored_range(density));
}

/// Whether the slice's plane has the whole volume on one side.
bool slice_misses_box(const View& view) {
  const std::optional<Plane>& plane = view.scene.slice;
  if (!view.scene.shows(Shows::plane) || !plane || !plane->point) return false;
  const glm::dvec3 half = 0.5 * (view.subject->box_max - view.subject->box_min);
  const glm::dvec3 middle = view.subject->box_min + half;
  return std::abs(glm::dot(plane->normal, middle - *plane->point)) >
         glm::dot(glm::abs(plane->normal), half);
}

/// The zoom at which the box fills the frame, for one that is inside.
double zoom_to_box(const View& view) {
  const Camera& camera = view.camera;
  double farthest = 1e-6;  // of the frame's half width or height
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner =
        glm::mix(view.subject->box_min, view.subject->box_max, glm::dvec3(cube_corner(i)));
    const glm::dvec3 way = corner - camera.position;
    const double reach = camera.orthographic ? 1 : glm::dot(way, camera.forward);
    farthest =
        std::max({farthest, std::abs(glm::dot(way, camera.right)) / (reach * camera.half_width),
                  std::abs(glm::dot(way, camera.up)) / (reach * camera.half_height)});
  }
  return 0.8 / farthest;
}

/// Why the picture shows another place than the volume's; empty if it shows that.
std::string why_beside(const View& view) {
  const Scene& scene = view.scene;
  if (cuts_all(*view.subject, clip_of(scene)))
    return std::string(scene.clip ? "--clip" : "--clip-plane") + " leaves nothing of " +
           place_of_volume(view);
  if (slice_misses_box(view)) return "--slice does not meet " + place_of_volume(view);
  if (camera_sees_box(view)) return {};
  const glm::dvec3 middle = glm::mix(view.subject->box_min, view.subject->box_max, 0.5);
  if (is_in_frame(middle, view.camera))
    return "no ray meets " + place_of_volume(view) + ": it is narrower than a pixel" +
           (scene.given.contains("zoom")
                ? ""
                : "; --zoom " + formatted("%.2g", zoom_to_box(view)) + " enlarges it");
  return "the camera looks past " + place_of_volume(view) + "; leave out the camera's options" +
         (scene.given.contains("camera-target")
              ? ""
              : ", or give --camera-target " + short_text(middle));
}

/// Why nothing is on the rays through the volume; empty if something is.
std::string why_empty(const View& view) {
  const Medium& medium = view.medium;
  const Scene& scene = view.scene;
  const glm::dvec2 values = stored_range(*medium.density);
  if (std::string lost = why_lost(view); !lost.empty()) return lost;
  if (scene.shows(Shows::surface)) {
    const auto is_among = [&](const ShownSurface& surface) {
      const double of_field = field_isovalue(surface.value, *medium.density);
      return of_field >= values.x && of_field <= values.y;
    };
    if (std::ranges::any_of(scene.isovalue, is_among)) return {};
    return "--isovalue " + parameter_text(scene, "isovalue") + " is not among the values of " +
           grid_text(view);
  }
  if (!medium.emission.empty() || !medium.others.empty() || scene.shows(Shows::plane) ||
      scene.shows(Shows::value))
    return {};
  if (scene.attenuates() && medium.extinction == 0) return "--extinction is 0";
  const bool attenuates = medium.transfer
                              ? medium.transfer->max_attenuation(
                                    values, {0, std::numeric_limits<double>::infinity()}) > 0
                              : values.y > 0;
  if (attenuates) return {};
  if (!medium.transfer) return "grid " + in_quotes(medium.density->name) + " has no value above 0";
  return "no value of " + grid_text(view) + ", has an attenuation above 0 by " +
         (scene.transfer_function.empty() ? "--range and --opacity" : "--transfer-function");
}

/// Why a maximum is dark; empty if it is not.
std::string why_low(const View& view) {
  const Scene& scene = view.scene;
  const double greatest = stored_range(*view.medium.density).y;
  if (scene.range && greatest <= view.medium.density->scale.scaled(scene.range->ends.x))
    return "--range begins at " + formatted("%.4g", scene.range->ends.x) +
           ", not below the values of " + grid_text(view);
  return {};
}

/// Why what is on the rays gives no light; empty if it might.
std::string why_dark(const View& view) {
  const Scene& scene = view.scene;
  if (scene.shows(Shows::value)) return why_low(view);
  if (!scene.lit() && scene.resolved_luminance() == glm::dvec3(0) && view.medium.emission.empty())
    return "--luminance is 0";
  if (!scene.composites()) return {};
  if (!scene.temperature_grid.empty())
    return "nothing in grid " + in_quotes(scene.temperature_grid) + " is hot enough to glow" +
           (scene.given.contains("temperature-scale")
                ? ""
                : "; --temperature-scale gives Kelvin per unit of its values");
  if (scene.lit() && scene.albedo == glm::dvec3(0)) return "--albedo is 0";
  if (scene.lit() && scene.environment.empty() &&
      scene.sky.value_or(glm::dvec3(0)) == glm::dvec3(0) &&
      std::ranges::all_of(scene.lights, [](const auto& l) { return l.color == glm::dvec3(0); }))
    return "the colour of --light or --sky is black";
  for (const EmissionOptions& emission : emission_options)
    if (!(scene.*emission.grid).empty() && scene.*emission.scale == 0)
      return "--" + std::string(emission.name) + "-scale is 0";
  if (!scene.luminance_grid.empty() && scene.luminance_scale == 0) return "--luminance-scale is 0";
  if (!scene.luminance_grid.empty())
    return "grid " + in_quotes(scene.luminance_grid) + ", the luminance, is 0 where it is seen";
  return {};
}

/// What a display shows of a picture.
struct Seen {
  double light = 0, opacity = 0;  ///< the greatest in any pixel
  /// Pixels that differ from the background in a code of 8 bits, as far as they are counted.
  std::size_t different = 0;
  bool has_contrast = false;  ///< some do at another exposure, that shows all of it
};

/// A picture in which less differs from its background is nearly empty.
constexpr double least_shown = 0.01;

/// Light of half a code; less is black on a display.
constexpr double least_light = half_code<double> / 12.92;

Seen what_is_seen(const Scene& scene, const Image& image, const Backdrop& behind) {
  Seen seen;
  const auto rgba = image.rgba();
  LaneRange<4> range;
  for (std::size_t i = 0; i < rgba.size(); i += 4) range.include(&rgba[i]);
  seen.light = std::max(0.0, double(range.greatest(0, 3)));
  seen.opacity = std::max(0.0, double(range.greatest(3, 1)));
  const double whole = 1 / std::max({seen.light, behind.greatest(), 1e-300});
  const double enough = least_shown * double(rgba.size() / 4);
  /// The pixels that differ, up to one more than `most`.
  const auto different = [&](double factor, double most) {
    const auto code = [&](double radiance) {
      return double(srgb_from_linear(
          std::min(display_light(float(radiance * factor), scene.tone_map), 1.0f)));
    };
    std::size_t count = 0;
    for (std::size_t i = 0; i < rgba.size() && double(count) <= most; i += 4) {
      const double left = scene.background ? 1 - double(rgba[i + 3]) : 0;
      const glm::dvec3 back = behind.at(i / 4);
      bool differs = false;
      for (int c = 0; c < 3; ++c) {
        const double light = double(rgba[i + std::size_t(c)]);
        if (light == 0 && (left == 1 || !scene.background)) continue;
        differs |= std::abs(code(light + left * back[c]) - code(back[c])) > half_code<double>;
      }
      count += differs;
    }
    return count;
  };
  seen.different = different(scene.exposure ? std::exp2(*scene.exposure) : whole, enough);
  seen.has_contrast = seen.different > 0 || different(whole, 0) > 0;
  return seen;
}

/// Why something that covers the background looks like it; empty if it is dark.
std::string why_alike(const Scene& scene, const Seen& seen, const Backdrop& behind) {
  const double brightest = behind.greatest();
  if (brightest <= least_light || seen.opacity <= least_light) return {};
  const double exposure = scene.exposure.value_or(0), shown = brightest * std::exp2(exposure);
  if (seen.has_contrast && (shown >= 1 || shown <= least_light))
    return "--exposure " + number_text(exposure) + " makes all of it " +
           (shown >= 1 ? "white" : "black") + "; --exposure auto shows it";
  const std::string what =
      scene.background->environment ? "environment" : short_text(scene.background->color);
  return "what is seen is as bright as --background " + what +
         (brightest > 0.2 ? "; --background black shows it" : "; --background white shows it");
}

}  // namespace

std::string why_lost(const View& view) {
  const glm::dvec2 values = stored_range(*view.medium.density);
  const double greatest = std::max(-values.x, values.y);
  constexpr double least_kept = 1e-35;
  if (greatest == 0 || greatest >= least_kept) return {};
  return "the values of " + grid_text(view) +
         ", are too small for float32; store the grid in another unit";
}

namespace {

/// Says that next to nothing is seen, and why; empty where the scene has chosen what is.
std::string nearly_empty(const View& view, std::size_t different, std::size_t pixels) {
  const Scene& scene = view.scene;
  if (double(different) > least_shown * double(pixels) || !view.medium.others.empty()) return {};
  for (const char* name :
       {"camera-position", "camera-target", "zoom", "clip", "clip-plane", "range", "opacity",
        "transfer-function", "isovalue", "extinction", "holdout"})
    if (scene.given.contains(name)) return {};
  const Field& density = *view.medium.density;
  const glm::ivec3 size = density.active_box.max - density.active_box.min + 1;
  const double voxels = double(size.x) * size.y * size.z;
  std::string why;
  if (double(density.active_voxels) < 1e-3 * voxels)
    why = ": grid " + in_quotes(density.name) +
          formatted(" has %.0f voxels among the %.4g of its box", double(density.active_voxels),
                    voxels);
  else if (const int longest = std::max({size.x, size.y, size.z});
           longest > 20 * (size.x + size.y + size.z - longest))
    why = ": grid " + in_quotes(density.name) +
          formatted(" is %dx%dx%d voxels, a line", size.x, size.y, size.z);
  return formatted("the picture is nearly empty, %zu of %zu pixels show something", different,
                   pixels) +
         why;
}

/// What was asked for that may keep all of the volume out of the picture; empty if nothing was.
std::string what_hides(const Scene& scene) {
  if (scene.clip || scene.clip_plane) return scene.clip ? "--clip" : "--clip-plane";
  if (!scene.holdout.empty()) return "--holdout";
  for (const char* name : {"camera-position", "camera-target", "zoom"})
    if (scene.given.contains(name)) return "the camera's options";
  return {};
}

}  // namespace

std::string blank_reason(const View& view, const Image& image) {
  View drawn = view;
  drawn.scene.resolution = {image.width, image.height};
  const Backdrop behind(drawn);
  const Seen seen = what_is_seen(view.scene, image, behind);
  if (seen.different > 0) return nearly_empty(view, seen.different, image.rgba().size() / 4);
  const bool empty = seen.opacity <= least_light;
  const Medium& medium = view.medium;
  if (empty && medium.density->active_voxels == 0 && medium.others.empty())
    return "the picture is empty: grid " + in_quotes(medium.density->name) + " has no active voxel";
  std::string why = why_alike(view.scene, seen, behind);
  if (!why.empty()) return "the picture shows only its background: " + why;
  if (empty) why = why_beside(view);
  if (empty && why.empty()) why = why_empty(view);
  if (why.empty() && empty && seen.light > 0 && seen.opacity > 0)
    why = "nothing covers more than " + formatted("%.2g", seen.opacity) +
          " of a pixel; a larger --extinction shows it";
  if (why.empty() && seen.light > 0)
    why = "its brightest light is " + formatted("%.2g", seen.light) + "; --exposure auto shows it";
  if (why.empty()) why = why_dark(view);
  if (why.empty()) {
    const std::string hides = what_hides(view.scene);
    why = "no ray meets anything that attenuates or glows" +
          (hides.empty() ? "" : "; leave out " + hides + " to see what is there");
  }
  return (empty ? "the picture is empty: " : "the picture is black: ") + why;
}

}  // namespace psivox
