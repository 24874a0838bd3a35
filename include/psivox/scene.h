#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "psivox/integrators.h"
#include "psivox/modes.h"
#include "psivox/value_scale.h"

namespace psivox {

/// Built-in colour maps; src/scene/named_colors.cpp says where each comes from.
enum class Colormap : int {
  viridis,
  inferno,
  magma,
  plasma,
  cividis,
  turbo,
  coolwarm,
  gray,
  hot,
  labels,  ///< a colour for each whole number, whatever the range; see label_function
};

/// The values at the ends of a map. Each is a number, or a percentile of the active values [%].
struct MapRange {
  MapRange(const glm::dvec2& ends_ = {0, 1}, const glm::bvec2& percent_ = {false, false})
      : ends(ends_), percent(percent_) {}

  glm::dvec2 ends;
  glm::bvec2 percent;  ///< whether an end is a percentile
  bool operator==(const MapRange&) const = default;
};

/// The factor of the attenuation over a MapRange: linear between points and constant outside.
struct OpacityCurve {
  std::vector<glm::dvec2> points{};  ///< place, 0 to 1, strictly ascending; and factor, at least 0
  bool operator==(const OpacityCurve&) const = default;

  double at(double place) const;
};

enum class Sampling { cells, uniform, template_ };
enum class Classification { post, pre, nearest };
enum class Centering { node, cell };
enum class Filter { exact, hardware };
enum class Projection { perspective, orthographic };
enum class UpAxis { automatic, y, z };
enum class RendererKind { gl, reference, march_double };
/// automatic: float32, or codes as coarse as a tolerance allows. code7, 12 and 16: the density's
/// bricks as codes of so many bits on the device, all else in float32.
enum class TexelType { automatic, float32, code7, code12, code16 };
constexpr bool has_codes(TexelType texel) { return texel >= TexelType::code7; }
enum class LightQuality { automatic, exact };
enum class EmissionColor { white, black_body };

/// A curve from radiance to the light of a display. `none`: radiance 1 is white, and more is cut.
/// `filmic`: Narkowicz's fit of ACES (shaders/math/colour.glsl), which has room above 1.
enum class ToneMap { none, filmic };

/// How another renderer counts depths: along the view, or along each ray.
enum class DepthKind { z, distance };

/// Parallel light.
struct DirectionalLight {
  /// Direction of travel, of any length but 0 [world, or the camera's right, up and backwards]
  glm::dvec3 direction{0, -1, 0};
  glm::dvec3 color{1};     ///< radiance of a medium of albedo 1, lit without loss
  bool of_camera = false;  ///< the direction turns with the camera
  bool operator==(const DirectionalLight&) const = default;
};

/// What is seen behind the medium.
struct Background {
  glm::dvec3 color{0};
  bool environment = false;  ///< the scene's environment, in place of the colour

  Background() = default;
  Background(const glm::dvec3& of) : color(of) {}
  bool operator==(const Background&) const = default;
};

struct WorldBox {
  glm::dvec3 min{0}, max{0};
  bool operator==(const WorldBox&) const = default;
};

/// One of the surfaces that `--mode isosurface` shows.
struct ShownSurface {
  double value = 0;
  std::optional<glm::dvec3> color{};  ///< unset: the scene's
  double opacity = 1;
  bool operator==(const ShownSurface&) const = default;
};

struct Plane {
  glm::dvec3 normal{0, 0, 1};         ///< of any length but 0 [world]
  std::optional<glm::dvec3> point{};  ///< unset: the middle of what is visible
  bool operator==(const Plane&) const = default;
};

/// Everything that a picture depends on, under the names of the command line, with the defaults.
/// The table of parameters.h lists the fields once more, for CLI, JSON and --help; nothing else
/// does. The default of an optional that is unset depends on the data or on another field.
struct Scene {
  std::string input;
  std::string look;  ///< see with_look; empty: not said
  std::string grid;  ///< empty: the best usable grid, see VolumeFile::default_grid
  /// Further volumes in the scene, each as "FILE NAME=VALUE ...", see scene_of_volume.
  std::vector<std::string> volumes;
  std::optional<double> background_value;  ///< in place of a grid's own, if that is not 0
  std::string fill_value = "auto";         ///< that is no data: a number, `auto` or `none`
  Centering centering = Centering::node;
  double scale = 1;      ///< of the volume about the world's origin, before it is turned and moved
  glm::dvec3 rotate{0};  ///< about the world's axes x, y and z, one after the other [degrees]
  glm::dvec3 translate{0};  ///< [world units]
  int lod = 0;              ///< level of detail: voxels are made twice as wide so many times
  std::optional<double> extinction;  ///< tau = extinction * value [1/world unit]; unset: auto
  ValueScale value_scale;            ///< of the density's values
  std::string transfer_function;     ///< file; empty: the value itself is the attenuation
  std::optional<Colormap> colormap;
  /// Values at the ends of the colour map, of --opacity and of maxima; without a map, also of the
  /// attenuation. Unset: see resolved_range.
  std::optional<MapRange> range;
  std::optional<OpacityCurve> opacity;  ///< over the range; unset: see window_function
  Classification classification = Classification::post;
  bool split_knots = false;  ///< segments end where the value crosses a knot of the function
  std::optional<glm::dvec3> luminance;  ///< unset: see resolved_luminance
  std::string luminance_grid;           ///< empty: constant luminance
  double luminance_scale = 1;
  std::string temperature_grid;   ///< empty: none
  double temperature_scale = 1;   ///< [K per unit of its values]
  double temperature_offset = 0;  ///< [K]
  std::string emission_grid;      ///< empty: none
  double emission_scale = 1;      ///< [radiance/world unit per unit of its values]
  /// The colour of a scalar emission grid; black_body: its values are temperatures.
  EmissionColor emission_color = EmissionColor::white;

  std::vector<DirectionalLight> lights;
  std::optional<glm::dvec3> sky;    ///< radiance of light that comes alike from all directions
  std::string environment;          ///< file of a map of the sky, see environment.h; empty: none
  double environment_rotation = 0;  ///< about the up axis, counterclockwise from above [degrees]
  double environment_scale = 1;     ///< [radiance per unit of the map]
  glm::dvec3 albedo{1};
  std::string albedo_grid;  ///< a factor of the albedo at each point; empty: none
  double phase_g = 0;       ///< mean cosine of the scattering angle (Henyey and Greenstein)
  int scatter_octaves = 1;  ///< see LitLuminance; 1: light is scattered once
  /// exact: a ray from each voxel to each light, whatever the tolerance.
  LightQuality light_quality = LightQuality::automatic;

  Mode mode = Mode::alpha;
  std::vector<ShownSurface> isovalue;  ///< empty: one, as resolved_isovalue says
  double lmip_threshold = 0;
  std::optional<Plane> slice;       ///< shown by mode slice; unset: across the view from the front
  std::optional<WorldBox> clip;     ///< only what is inside is drawn
  std::optional<Plane> clip_plane;  ///< only what is on the side of its normal is drawn
  std::string holdout;              ///< FILE[:LAYER] of opaque depths; empty: none
  DepthKind holdout_depth = DepthKind::z;

  std::optional<Integrator> integrator;  ///< psi_weighted under cells, psi_balanced under uniform
  std::optional<Sampling> sampling;      ///< cells, or uniform where step is set
  int segments = 2;                      ///< linear segments per cell
  std::optional<double> step;            ///< [voxels of the finest index axis]; unset: 1
  bool end_corrections = true;      ///< psi-balanced corrects where a ray's samples begin and end
  int connectivity = 26;            ///< of a ray template's voxels: 6, 18 or 26
  double opacity_unit = 1;          ///< [voxels of the finest index axis], opacity_linear's
  std::optional<double> tolerance;  ///< largest RMS error over R G B A; chooses the method
  /// Transmittance at which a ray ends; 0: never. Unset: 1/16384, or at most a quarter of the
  /// tolerance.
  std::optional<double> early_termination;
  Filter filter = Filter::exact;
  TexelType texel = TexelType::automatic;
  RendererKind renderer = RendererKind::gl;

  std::optional<glm::dvec3> camera_position;
  std::optional<glm::dvec3> camera_target;
  std::optional<glm::dvec3> camera_up;  ///< unset: the axis that up_axis names
  UpAxis up_axis = UpAxis::automatic;   ///< automatic: as the file tells, else y
  double azimuth = 0;         ///< turns the camera about the up axis, to the right [degrees]
  double elevation = 0;       ///< then raises it [degrees]
  double zoom = 1;            ///< magnification: the field of view is narrower
  std::optional<double> fov;  ///< horizontal [degrees]; unset: from focal_length and aperture
  double focal_length = 50;   ///< [mm]
  double aperture = 41.2136;  ///< [mm]
  Projection projection = Projection::perspective;
  std::optional<double> ortho_width;  ///< width of the image plane [world units]

  glm::ivec2 resolution{1280, 720};
  std::optional<Background> background;
  std::optional<double> exposure = 0;  ///< [powers of 2] of sRGB codes and the window; unset: auto
  ToneMap tone_map = ToneMap::none;    ///< of sRGB codes and the window
  std::string ocio;          ///< file of an OpenColorIO config; empty: $OCIO, if asked for
  std::string ocio_display;  ///< empty: the config's first
  std::string ocio_view;     ///< empty: the display's first
  std::string ocio_space;    ///< of the picture's light; empty: the config's scene_linear
  // what is drawn into sRGB codes
  std::optional<std::string> color_bar;  ///< its title; empty: the grid's name
  bool scale_bar = false;
  bool axes = false;
  bool box = false;
  std::string title;
  int pixel_samples = 1;

  bool strict = false;
  int device = -1;  ///< EGL device; -1: the first that works, hardware before software
  std::uint64_t memory_limit = 0;  ///< [bytes] of grids, host and GPU; 0: see grid_memory

  /// Parameters that a text has set, if only to their defaults: no look replaces them.
  std::set<std::string, std::less<>> given;

  Sampling resolved_sampling() const {
    return sampling.value_or(step ? Sampling::uniform : Sampling::cells);
  }
  Integrator resolved_integrator() const {
    if (!volumes.empty()) return integrator.value_or(Integrator::cell_exact);
    return integrator.value_or(resolved_sampling() == Sampling::cells ? Integrator::psi_weighted
                                                                      : Integrator::psi_balanced);
  }
  bool shows(Shows what) const { return info(mode).shows == what; }
  /// Whether values are placed in a range before they are attenuations, colours or maxima.
  bool windows() const {
    return transfer_function.empty() &&
           (colormap || opacity || range || !value_scale.is_linear() || shows(Shows::value));
  }
  bool has_function() const { return !transfer_function.empty() || windows(); }
  /// Whether segments are composited. If not, the picture depends on the density's values alone and
  /// ignores other grids and light; a surface has colours from the luminance's grid, and lights.
  bool composites() const { return shows(Shows::light); }
  /// Whether the picture depends on optical depths and so on the extinction.
  bool attenuates() const { return composites() || shows(Shows::depth); }
  /// Whether the medium can attenuate, and so shine.
  bool has_extinction() const { return attenuates() && extinction != 0.0; }
  bool lit() const {
    return (!lights.empty() || sky || !environment.empty()) && composites() && has_extinction();
  }
  /// If unset: 1, or 0 if a light shines on the medium and no grid gives it luminance of its own.
  glm::dvec3 resolved_luminance() const {
    const bool dark = lit() && luminance_grid.empty() && temperature_grid.empty();
    return luminance.value_or(glm::dvec3(dark ? 0 : 1));
  }
  /// Whether a grid or a function of luminance changes the picture.
  bool shines() const {
    if (shows(Shows::surface) || shows(Shows::plane)) return resolved_luminance() != glm::dvec3(0);
    return composites() && has_extinction() && (lit() || resolved_luminance() != glm::dvec3(0));
  }
  /// Whether sRGB codes and the window show light through a view of OpenColorIO: only if a scene
  /// asks for it, because other programs set $OCIO too.
  bool uses_ocio() const {
    return !ocio.empty() || !ocio_display.empty() || !ocio_view.empty() || !ocio_space.empty();
  }
  double resolved_step() const { return step.value_or(1.0); }
  double resolved_early_termination() const {
    return early_termination.value_or(tolerance ? std::min(*tolerance, 1.0) / 4 : 1.0 / 16384);
  }
};

/// The options of a grid that emits: name-grid, name-scale, name-color.
struct EmissionOptions {
  const char* name;
  std::string Scene::*grid;
  double Scene::*scale;
  EmissionColor Scene::*color;
};

/// Of all that may emit; they are the last rows of shaders/grids.glsl, in the same order.
inline constexpr EmissionOptions emission_options[] = {
    {"emission", &Scene::emission_grid, &Scene::emission_scale, &Scene::emission_color}};

/// How the march evaluates the integral along a ray: by which rule, between which points.
struct Method {
  Integrator integrator = Integrator::psi_weighted;
  Sampling sampling = Sampling::cells;
  int segments = 0;  ///< linear segments per cell, under cells; else 0
  double step = 0;   ///< [voxels of the finest axis], under uniform; else 0
  bool operator==(const Method&) const = default;
};

/// "uniform psi-balanced, step 1.7", "cells psi-weighted, segments 2", "cells cell-exact".
std::string method_text(const Method& method);

/// The scene with that method and without a tolerance, which would choose another.
Scene with_method(Scene scene, const Method& method);

}  // namespace psivox
