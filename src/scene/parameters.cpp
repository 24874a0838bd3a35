#include "psivox/parameters.h"

#include <cmath>

#include "psivox/error.h"
#include "scene/enum_names.h"

namespace psivox {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Range any{};
constexpr Range at_least_0{0, infinity};
constexpr Range above_0{0, infinity, true};

std::vector<Parameter> make_table() {
  const std::string input = "Input", medium = "Medium", march = "March", camera = "Camera",
                    picture = "Picture", machine = "Machine";
  std::vector<Parameter> table = {
      {"input", "IN.vdb", "", "", "volume to render", input, &Scene::input, any, "", true},
      {"grid", "NAME", "", "`density`, else the only scalar grid",
       "density grid; `density[1]` where names repeat", input, &Scene::grid},
      {"strict", "", "", "",
       "NaN, Inf, negative values and non-linear transforms are errors, not notices", input,
       &Scene::strict},

      {"extinction", "K", "1/world unit", "auto: the mean ray through the middle has depth 3",
       "attenuation = K * value", medium, &Scene::extinction, at_least_0, "auto"},
      {"luminance", "R,G,B", "", "", "luminance of the medium", medium, &Scene::luminance,
       at_least_0},
      {"luminance-grid", "NAME", "", "none",
       "scalar or vec3 grid whose value multiplies the luminance", medium, &Scene::luminance_grid},
      {"luminance-scale", "S", "", "", "factor of the luminance grid's values", medium,
       &Scene::luminance_scale, at_least_0},

      {"integrator", enum_metavar<Integrator>(), "", "psi-weighted under cells, else psi-balanced",
       "rule for one segment", march, &Scene::integrator, any, "auto"},
      {"sampling", enum_metavar<Sampling>(), "", "cells, or uniform where --step is given",
       "segments from voxel face to voxel face, or of equal length", march, &Scene::sampling, any,
       "auto"},
      {"segments", "N", "", "", "linear segments a cell", march, &Scene::segments, {1, 64}},
      {"step", "H", "voxels of the finest axis", "1", "uniform step; implies --sampling uniform",
       march, &Scene::step, above_0, "auto"},
      {"early-termination",
       "T",
       "transmittance",
       "",
       "ends a ray below it; 0: never",
       march,
       &Scene::early_termination,
       {0, 1, false, true}},
      {"filter", enum_metavar<Filter>(), "", "", "trilinear weights: in float32, or the GPU's own",
       march, &Scene::filter},
      {"texel", enum_metavar<TexelType>(), "", "", "type of the atlas's values", march,
       &Scene::texel},
      {"renderer", enum_metavar<RendererKind>(), "", "",
       "GPU; adaptive quadrature on the CPU; the GPU's march in double on the CPU", march,
       &Scene::renderer},

      {"camera-position", "X,Y,Z", "world units", "where the whole grid is in frame", "the eye",
       camera, &Scene::camera_position, any, "auto"},
      {"camera-target", "X,Y,Z", "world units", "the grid's centre, or along -Z", "looked at",
       camera, &Scene::camera_target, any, "auto"},
      {"camera-up", "X,Y,Z", "", "", "direction that is upwards in the picture", camera,
       &Scene::camera_up},
      {"fov",
       "DEG",
       "degrees",
       "from --focal-length and --aperture, over which it wins",
       "horizontal field of view",
       camera,
       &Scene::fov,
       {0, 180, true, true},
       "auto"},
      {"focal-length", "F", "mm", "", "of the lens", camera, &Scene::focal_length, above_0},
      {"aperture", "A", "mm", "", "width of the film", camera, &Scene::aperture, above_0},
      {"projection", enum_metavar<Projection>(), "", "", "kind of camera", camera,
       &Scene::projection},
      {"ortho-width", "W", "world units", "the whole grid in frame",
       "width of the orthographic image plane", camera, &Scene::ortho_width, above_0, "auto"},

      {"resolution",
       "WxH",
       "pixels",
       "",
       "size of the picture",
       picture,
       &Scene::resolution,
       {1, 65536}},
      {"background", "R,G,B", "", "none: premultiplied, with alpha", "composited behind", picture,
       &Scene::background, at_least_0, "none"},
      {"pixel-samples",
       "N",
       "",
       "",
       "rays a pixel, stratified, averaged; 1: the centre",
       picture,
       &Scene::pixel_samples,
       {1, 4096}},

      {"device",
       "N",
       "",
       "-1: the first that works",
       "EGL device, as --list-devices numbers them",
       machine,
       &Scene::device,
       {-1, 1024}},
      {"memory-limit", "SIZE", "bytes", "0: none",
       "for the atlas on host and GPU together; 512M, 1.5GiB", machine, &Scene::memory_limit},
  };
  const Scene defaults;
  for (Parameter& row : table) {
    if (row.default_text.empty()) row.default_text = parameter_text(defaults, row);
  }
  return table;
}

bool contains(std::span<const Setting> settings, std::string_view name) {
  for (const Setting& setting : settings) {
    if (setting.name == name) return true;
  }
  return false;
}

}  // namespace

const std::vector<Parameter>& parameters() {
  static const std::vector<Parameter> table = make_table();
  return table;
}

const Parameter* find_parameter(std::string_view name) {
  for (const Parameter& row : parameters()) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

void apply_over(Scene& scene, std::span<const Setting> settings) {
  if (contains(settings, "step") && !contains(settings, "sampling")) scene.sampling.reset();
  for (const Setting& setting : settings) set_parameter(scene, setting.name, setting.text);
  if (scene.sampling == Sampling::cells && !contains(settings, "step")) scene.step.reset();
  if (scene.projection == Projection::perspective && !contains(settings, "ortho-width"))
    scene.ortho_width.reset();
  const bool lens = contains(settings, "focal-length") || contains(settings, "aperture");
  if (lens && !contains(settings, "fov")) scene.fov.reset();
}

void validate(const Scene& scene) {
  const auto fail = [](const char* message) { throw Error(ExitCode::usage, message); };
  if (scene.step && scene.sampling == Sampling::cells)
    fail("--step is for --sampling uniform, not cells; leave one of them out");
  if (scene.integrator && is_cell_rule(*scene.integrator) &&
      scene.resolved_sampling() != Sampling::cells)
    fail("--integrator cell-exact integrates cells; it goes with --sampling cells, without --step");
  if (scene.ortho_width && scene.projection == Projection::perspective)
    fail("--ortho-width is for --projection orthographic; a perspective view has --fov");
  if (scene.camera_up == glm::dvec3(0)) fail("--camera-up 0,0,0 has no direction");
  if (scene.camera_position && scene.camera_position == scene.camera_target)
    fail("--camera-position and --camera-target are the same point; move one of them");
}

}  // namespace psivox
