#include "psivox/parameters.h"

#include "scene/enum_names.h"

namespace psivox {
namespace {

constexpr Range any{};
constexpr Range at_least_0{.min = 0};
constexpr Range above_0{.min = 0, .min_open = true};
constexpr Range fraction{0, 1};
constexpr Range forward{-1, 1, true, true};
constexpr Range neighbours{6, 26};

std::vector<Parameter> make_table() {
  const std::string input = "Input", medium = "Medium", light = "Light", march = "March",
                    camera = "Camera", picture = "Picture", machine = "Machine";
  std::vector<Parameter> table = {
      {"input", "IN.vdb", "", "", "volume to render", input, &Scene::input, any, "", true},
      {"grid", "NAME", "", "`density`, else the only scalar grid",
       "density grid; `density[1]` where names repeat", input, &Scene::grid},
      {"strict", "", "", "",
       "NaN, Inf, negative values and non-linear transforms are errors, not notices", input,
       &Scene::strict},
      {"centering", enum_metavar<Centering>(), "", "",
       "value i is at index i, or at i + 1/2: the same picture, shifted by half a voxel", input,
       &Scene::centering},

      {"extinction", "K", "1/world unit", "auto: the mean ray through the middle has depth 3",
       "attenuation = K * value, or K times the transfer function's", medium, &Scene::extinction,
       at_least_0, "auto"},
      {"transfer-function", "FILE", "", "none",
       "JSON: attenuation and colour of the value (and gradient), linear between points; "
       "ParaView's too",
       medium, &Scene::transfer_function},
      {"colormap", enum_metavar<Colormap>(), "", "none", "luminance of the value", medium,
       &Scene::colormap, any, "none"},
      {"range", "MIN,MAX", "", "the least and the greatest active value",
       "values at the ends of the colour map", medium, &Scene::range, any, "auto"},
      {"classification", enum_metavar<Classification>(), "", "",
       "the function of interpolated values, or interpolation of the voxels' functions", medium,
       &Scene::classification},
      {"split-knots", "", "", "",
       "split segments where the value crosses a knot of the transfer function; cell-exact always "
       "does",
       medium, &Scene::split_knots},
      {"luminance", "R,G,B", "", "1,1,1; with --light alone 0,0,0",
       "luminance of the medium, a factor of what a grid or a function gives", medium,
       &Scene::luminance, at_least_0, "auto"},
      {"luminance-grid", "NAME", "", "none",
       "scalar or vec3 grid whose value multiplies the luminance", medium, &Scene::luminance_grid},
      {"luminance-scale", "S", "", "", "factor of the luminance grid's values", medium,
       &Scene::luminance_scale, at_least_0},
      {"temperature-grid", "NAME", "", "none",
       "scalar grid: luminance of a black body of S * value + O, 1 at 6500 K", medium,
       &Scene::temperature_grid},
      {"temperature-scale", "S", "", "", "factor of the temperature grid's values", medium,
       &Scene::temperature_scale, at_least_0},
      {"temperature-offset", "O", "K", "", "added to the scaled temperature", medium,
       &Scene::temperature_offset},
      {"emission-grid", "NAME", "", "none",
       "scalar or vec3 grid: light that the medium adds whatever its attenuation", medium,
       &Scene::emission_grid},
      {"emission-scale", "S", "radiance/world unit", "", "factor of the emission grid's values",
       medium, &Scene::emission_scale, at_least_0},

      {"light", "X,Y,Z[,R,G,B]", "", "none",
       "directional light that travels along X,Y,Z, scattered once; colour 1,1,1", light,
       &Scene::light, at_least_0, "none"},
      {"albedo", "A", "", "", "part of the light that is scattered, not absorbed", light,
       &Scene::albedo, fraction},
      {"phase-g", "G", "", "", "mean cosine of scattering: 0 isotropic, 1 forward", light,
       &Scene::phase_g, forward},

      {"mode", enum_metavar<Mode>(), "", "", "how a ray's samples become a pixel", march,
       &Scene::mode},
      {"isovalue", "V", "", "the middle of the values, 0 of a level set",
       "value of the surface of --mode isosurface", march, &Scene::isovalue, any, "auto"},
      {"lmip-threshold", "T", "", "", "--mode lmip takes the first local maximum above it", march,
       &Scene::lmip_threshold},

      {"integrator", enum_metavar<Integrator>(), "", "psi-weighted under cells, else psi-balanced",
       "rule for one segment", march, &Scene::integrator, any, "auto"},
      {"sampling", enum_metavar<Sampling>(), "", "cells, or uniform where --step is given",
       "segments from voxel face to voxel face, of equal length, or a ray template's voxels "
       "(orthographic only)",
       march, &Scene::sampling, any, "auto"},
      {"segments", "N", "", "", "linear segments a cell", march, &Scene::segments, {1, 64}},
      {"step", "H", "voxels of the finest axis", "1", "uniform step; implies --sampling uniform",
       march, &Scene::step, above_0, "auto"},
      {"tolerance", "E", "radiance, opacity", "none",
       "root-mean-square error over R G B A that the picture may have: chooses sampling, step and "
       "integrator",
       march, &Scene::tolerance, above_0, "none"},
      {"end-corrections", "", "", "",
       "under uniform psi-balanced: corrects where a ray begins or ends inside the medium", march,
       &Scene::end_corrections},
      {"connectivity", "6|18|26", "", "", "neighbours of a ray template's voxels", march,
       &Scene::connectivity, neighbours},
      {"opacity-unit", "U", "voxels of the finest axis", "",
       "length of which opacity-linear's opacities are", march, &Scene::opacity_unit, above_0},
      {"early-termination",
       "T",
       "transmittance",
       "1/16384; a quarter of --tolerance",
       "ends a ray below it; 0: never",
       march,
       &Scene::early_termination,
       {0, 1, false, true},
       "auto"},
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

}  // namespace psivox
