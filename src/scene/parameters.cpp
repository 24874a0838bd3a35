#include "psivox/parameters.h"

#include <algorithm>

#include "base/text.h"
#include "scene/enum_names.h"

namespace psivox {
namespace {

constexpr Range any{};
constexpr Range at_least_0{.min = 0};
constexpr Range above_0{.min = 0, .min_open = true};
constexpr Range fraction{0, 1};
constexpr Range forward{-1, 1, true, true};
constexpr Range neighbours{6, 26};
constexpr Range below_1{.min = 0, .max = 1, .max_open = true};
constexpr Range angle{0, 180, true, true};
constexpr Range segment_count{1, 64};
constexpr Range pixel_count{1, 65536};
constexpr Range sample_count{1, 4096};
constexpr Range device_index{-1, 1024};
constexpr Range octave_count{1, 16};
constexpr Range halvings{0, 16};

/// The row with another value in a column.
template <auto column, auto value>
Parameter with(Parameter p) {
  p.*column = value;
  return p;
}

constexpr auto chosen = with<&Parameter::under_tolerance, UnderTolerance::chosen>;
constexpr auto unchanged = with<&Parameter::under_tolerance, UnderTolerance::unchanged>;
constexpr auto common = with<&Parameter::common, true>;
constexpr auto march_only = with<&Parameter::march_only, true>;
constexpr auto own_or_scenes = with<&Parameter::of_volume, OfVolume::own_or_scenes>;
constexpr auto own = with<&Parameter::of_volume, OfVolume::own>;
constexpr auto not_of_volumes = with<&Parameter::of_volume, OfVolume::none>;

using Rows = std::vector<Parameter>;

Rows input_rows() {
  return {
      {"input", "IN.vdb", "", "", "volume to render", &Scene::input, any, "", true},
      common(own(
          {"grid", "NAME[:PART]", "", "the best usable grid",
           "density grid; density[1] is the second of that name; of vectors :x, :y, :z or :length; "
           ":active is 1 at active voxels",
           &Scene::grid})),
      {"volumes", "FILE", "", "none",
       "draw another volume in the same scene; several may be given. It takes the scene's options; "
       "NAME=VALUE behind its file replaces one of these: ",
       &Scene::volumes, any, "none"},
      {"strict", "", "", "",
       "refuse NaN, Inf, negative values, backgrounds and non-linear transforms", &Scene::strict},
      {"background-value", "V", "", "none: 0, said in a notice",
       "value of a grid outside its voxels and tiles, where the file's own is not 0; 0: empty",
       &Scene::background_value, any, "none"},
      {"fill-value", "V|auto|none", "", "",
       "value that stands for no data; auto: one apart from all others at their lower end, or as "
       "large as float32 allows",
       &Scene::fill_value},
      {"centering", enum_metavar<Centering>(), "", "",
       "place value i at index i (node) or i + 1/2 (cell)", &Scene::centering},
      own({"scale", "S", "", "", "make the volume S times as large, about the world's origin",
           &Scene::scale, above_0}),
      own({"rotate", "X,Y,Z", "degrees", "",
           "then turn it about the world's axes x, y and z, in turn", &Scene::rotate}),
      own({"translate", "X,Y,Z", "world units", "", "then move it", &Scene::translate}),
      {"lod", "N", "", "", "level of detail: make voxels twice as wide N times, of mean values",
       &Scene::lod, halvings},
  };
}

Rows output_rows() {
  return {
      common({"resolution", "WxH", "pixels", "", "size of the picture", &Scene::resolution,
              pixel_count}),
      common({"background", "COLOUR", "", "none: premultiplied, with alpha",
              "colour behind the medium: R,G,B is linear, #rrggbb and the names of CSS are sRGB; "
              "environment: the map of --environment",
              &Scene::background, at_least_0, "none"}),
      {"exposure", "STOPS", "powers of 2", "0; auto under --mode xray",
       "brightness of .png, .jpg, .webp, 8-bit .tif and the window; auto: just below white",
       &Scene::exposure, any, "auto"},
      {"tone-map", enum_metavar<ToneMap>(), "", "",
       "curve of the same outputs; filmic: ACES, fitted by Narkowicz", &Scene::tone_map},
      {"ocio", "FILE", "", "$OCIO if an option below is given, else none",
       "show the same outputs by a view of this OpenColorIO config", &Scene::ocio},
      {"ocio-display", "NAME", "", "the config's first", "display of that config",
       &Scene::ocio_display},
      {"ocio-view", "NAME", "", "the display's first", "view of that display", &Scene::ocio_view},
      {"ocio-space", "NAME", "", "scene_linear",
       "colour space or role of that config that the picture's light is in", &Scene::ocio_space},
      {"color-bar", "[TITLE]", "", "false",
       "draw the map's colours and values into the same outputs, under a title such as "
       "\"temperature [K]\"; without one, the grid's name",
       &Scene::color_bar, any, "false"},
      {"scale-bar", "", "", "", "draw a bar of a round length [world units] into the same outputs",
       &Scene::scale_bar},
      {"axes", "", "", "", "draw the directions of the world's axes into the same outputs",
       &Scene::axes},
      {"box", "", "", "", "draw the volume's box with ticks [world units] into the same outputs",
       &Scene::box},
      {"title", "TEXT", "", "none", "write a title into the same outputs", &Scene::title},
      {"pixel-samples", "N", "", "", "rays per pixel, stratified; 1 is the pixel's centre",
       &Scene::pixel_samples, sample_count},
  };
}

Rows look_rows() {
  return {
      common(
          {"look", "NAME", "", "auto in render, view and study",
           "scene parameters that suit the file: auto, plain, smoke, fire, surface, scan, labels, "
           "signed, points, colors, vectors, mip or xray, or a .json of them; each option given "
           "replaces its own part",
           &Scene::look}),
      common(own_or_scenes({"extinction", "K", "1/world unit",
                            "auto: mean optical depth 3 through the grid's middle",
                            "scale of the attenuation: K * value, or K * transfer function",
                            &Scene::extinction, at_least_0, "auto"})),
      {"value-scale", "linear|log|symlog[:T]", "", "",
       "what voxels' values pass through before range, opacity, colour and isovalue, which stay in "
       "the file's values: log10 of those above 0, or of 1 + |value| / T with its sign",
       &Scene::value_scale},
      {"transfer-function", "FILE", "", "none",
       "JSON: attenuation and colour by value and gradient; ParaView's colour maps too",
       &Scene::transfer_function},
      common({"colormap", enum_metavar<Colormap>(), "", "none",
              "built-in colour map of the luminance", &Scene::colormap, any, "none"}),
      {"range", "MIN,MAX", "", "range of the active values; 0 to the greatest for mip and lmip",
       "values at the ends of --colormap, --opacity and maxima; with none of these, of the "
       "attenuation; 1%,99% are percentiles",
       &Scene::range, any, "auto"},
      {"opacity", "U:A,...", "", "none",
       "factor A of the extinction at places U of the range, 0 to 1: 0:0,0.3:0.1,1:1",
       &Scene::opacity, any, "none"},
      {"classification", enum_metavar<Classification>(), "", "",
       "apply the function after (post) or before (pre) the interpolation, or to the nearest "
       "voxel; its colours in light, too",
       &Scene::classification},
      own_or_scenes({"luminance", "COLOUR", "", "1,1,1; 0,0,0 with --light alone",
                     "luminance of the medium; a grid or a function multiplies it",
                     &Scene::luminance, at_least_0, "auto"}),
      not_of_volumes({"luminance-grid", "NAME", "", "none",
                      "scalar or vec3 grid that multiplies the luminance", &Scene::luminance_grid}),
      {"luminance-scale", "S", "", "", "factor of --luminance-grid", &Scene::luminance_scale,
       at_least_0},
      not_of_volumes({"temperature-grid", "NAME", "", "none",
                      "scalar grid of black-body temperatures; 6500 K has luminance 1",
                      &Scene::temperature_grid}),
      own_or_scenes({"temperature-scale", "S", "", "", "factor of --temperature-grid",
                     &Scene::temperature_scale, at_least_0}),
      own_or_scenes({"temperature-offset", "O", "K", "", "temperature added after the factor",
                     &Scene::temperature_offset}),
      own({"emission-grid", "NAME", "", "none",
           "scalar or vec3 grid of emitted light; the extinction does not scale it",
           &Scene::emission_grid}),
      own({"emission-scale", "S", "radiance/world unit", "", "factor of --emission-grid",
           &Scene::emission_scale, at_least_0}),
      own({"emission-color", enum_metavar<EmissionColor>(), "", "",
           "colour of a scalar emission grid; black-body: its values are temperatures, by "
           "--temperature-scale and --temperature-offset",
           &Scene::emission_color}),
  };
}

Rows mode_and_part_rows() {
  return {
      common({"mode", enum_metavar<Mode>(), "", "",
              "how a pixel is made of the values along its ray", &Scene::mode}),
      {"isovalue", "V[:COLOUR][:OPACITY],...", "",
       "Otsu's threshold between low and high values; 0 for a level set",
       "values of the surfaces, under --mode isosurface, such as 0.2:#ff8800:0.3,0.5",
       &Scene::isovalue, any, "auto"},
      march_only({"lmip-threshold", "T", "", "",
                  "--mode lmip shows the first local maximum of at least T",
                  &Scene::lmip_threshold}),
      march_only({"slice", "PLANE", "world units", "across the default view, through the middle",
                  "plane of --mode slice: z, z=3, a normal, or a point and a normal", &Scene::slice,
                  any, "auto"}),
      march_only({"clip", "BOX", "world units", "none",
                  "draw only what is in the box X0,Y0,Z0,X1,Y1,Z1", &Scene::clip, any, "none"}),
      march_only({"clip-plane", "PLANE", "world units", "none",
                  "draw only what is before the plane, on the side of its normal: x=3, -x=3, a "
                  "normal, or a "
                  "point and a normal",
                  &Scene::clip_plane, any, "none"}),
      march_only({"holdout", "FILE[:LAYER]", "", "none",
                  "end rays at the opaque depths that another renderer has drawn through the same "
                  "camera, in a layer of an EXR",
                  &Scene::holdout}),
      march_only({"holdout-depth", enum_metavar<DepthKind>(), "", "",
                  "what these depths are: z along the view, or the distance from the camera",
                  &Scene::holdout_depth}),
  };
}

Rows light_rows() {
  return {
      {"light", "X,Y,Z[,COLOUR]", "", "none",
       "direction and colour of parallel light, scattered once; several may be given; camera:X,Y,Z "
       "turns with the camera (right, up, backwards); the colour is white if left out",
       &Scene::lights, at_least_0, "none"},
      {"sky", "COLOUR", "", "none", "light that comes alike from all directions, scattered once",
       &Scene::sky, at_least_0, "none"},
      {"environment", "FILE", "", "none",
       "light from a latitude-longitude map (.hdr, .exr), scattered once; its middle is seen along "
       "+X if z is up, along +Z if y is up",
       &Scene::environment},
      {"environment-rotation", "DEG", "degrees", "",
       "turn the map about the up axis, counterclockwise from above", &Scene::environment_rotation},
      {"environment-scale", "S", "radiance", "", "factor of the map", &Scene::environment_scale,
       above_0},
      own_or_scenes({"albedo", "A|COLOUR", "", "",
                     "scattered part of the attenuated light: one number, or one for each colour",
                     &Scene::albedo, fraction}),
      own({"albedo-grid", "NAME", "", "none",
           "grid that multiplies the albedo: of one number or a colour (vec3), or the three grids "
           "NAME_r, NAME_g and NAME_b of colour times density, as Blender's smoke has them",
           &Scene::albedo_grid}),
      {"phase-g", "G", "", "", "mean cosine of the scattering angle: 0 isotropic, near 1 forward",
       &Scene::phase_g, forward},
      {"scatter-octaves", "N", "", "",
       "octaves that stand for light that is scattered more than once; 1 is light scattered once",
       &Scene::scatter_octaves, octave_count},
      {"light-quality", enum_metavar<LightQuality>(), "", "",
       "auto: as exact as --tolerance asks; exact: a ray from each voxel to each light",
       &Scene::light_quality},
  };
}

Rows camera_rows() {
  return {
      {"camera-position", "X,Y,Z", "world units", "all that is visible in frame, from the front",
       "position of the eye", &Scene::camera_position, any, "auto"},
      {"camera-target", "X,Y,Z", "world units", "middle of what is visible",
       "point in the picture's middle", &Scene::camera_target, any, "auto"},
      {"camera-up", "X,Y,Z", "", "the axis of --up-axis", "direction that is up in the picture",
       &Scene::camera_up, any, "auto"},
      {"up-axis", enum_metavar<UpAxis>(), "", "auto: z for files of Z-up programs, else y",
       "axis that is up: y is seen along -Z, z along +Y", &Scene::up_axis},
      common({"azimuth", "DEG", "degrees", "0; 30 in looks",
              "turn the camera about the up axis, to the right", &Scene::azimuth}),
      common({"elevation", "DEG", "degrees", "0; 20 in looks", "then raise it over its target",
              &Scene::elevation}),
      {"zoom", "F", "", "", "show everything F times as large; narrows the field of view",
       &Scene::zoom, above_0},
      {"fov", "DEG", "degrees", "from --focal-length and --aperture", "horizontal field of view",
       &Scene::fov, angle, "auto"},
      {"focal-length", "F", "mm", "", "focal length of the lens", &Scene::focal_length, above_0},
      {"aperture", "A", "mm", "", "width of the film", &Scene::aperture, above_0},
      {"projection", enum_metavar<Projection>(), "", "", "projection of the camera",
       &Scene::projection},
      {"ortho-width", "W", "world units", "all that is visible in frame",
       "width of the picture, under --projection orthographic", &Scene::ortho_width, above_0,
       "auto"},
  };
}

Rows accuracy_rows() {
  return {
      march_only(common(
          {"tolerance", "E", "radiance, opacity",
           number_text(default_tolerance) + ", unless --step or another option sets the method",
           "largest RMS error over R, G, B and A; psivox chooses the method for it. What light "
           "arrives is computed at voxels and interpolated: how it varies between them does not "
           "count; colours do",
           &Scene::tolerance, above_0, "none"})),
      march_only({"early-termination", "T", "transmittance", "1/16384, or at most --tolerance / 4",
                  "end a ray below this transmittance; 0: never", &Scene::early_termination,
                  below_1, "auto"}),
      chosen(march_only(
          {"sampling", enum_metavar<Sampling>(), "", "cells; uniform with --step",
           "divide a ray at voxel faces, into equal steps, or by a template (orthographic)",
           &Scene::sampling, any, "auto"})),
      chosen(march_only({"integrator", enum_metavar<Integrator>(), "",
                         "psi-weighted under cells, else psi-balanced",
                         "rule that integrates a segment", &Scene::integrator, any, "auto"})),
      chosen(march_only({"step", "H", "voxels of the finest axis", "1",
                         "length of a step; implies --sampling uniform", &Scene::step, above_0,
                         "auto"})),
      chosen(
          march_only({"segments", "N", "", "", "linear segments per cell, under --sampling cells",
                      &Scene::segments, segment_count})),
      chosen({"split-knots", "", "", "",
              "end segments at the knots of the transfer function; cell-exact always does",
              &Scene::split_knots}),
      march_only({"end-corrections", "", "", "",
                  "correct psi-balanced for rays that begin or end inside the medium",
                  &Scene::end_corrections}),
      march_only({"connectivity", "6|18|26", "", "",
                  "neighbours of a voxel, under --sampling template", &Scene::connectivity,
                  neighbours}),
      march_only({"opacity-unit", "U", "voxels of the finest axis", "",
                  "length that an opacity of opacity-linear refers to", &Scene::opacity_unit,
                  above_0}),
      unchanged(march_only({"filter", enum_metavar<Filter>(), "", "",
                            "interpolate in float32 (exact) or by the GPU's texture unit",
                            &Scene::filter})),
      unchanged(
          {"texel", enum_metavar<TexelType>(), "", "",
           "type of the stored values; auto: float32, and codes as coarse as --tolerance allows",
           &Scene::texel}),
      march_only({"renderer", enum_metavar<RendererKind>(), "", "",
                  "GPU, reference integrator on the CPU, or the GPU's march in double on the CPU",
                  &Scene::renderer}),
  };
}

Rows machine_rows() {
  return {
      march_only({"device", "N", "", "-1: the first that works",
                  "EGL device, as --list-devices numbers them", &Scene::device, device_index}),
      {"memory-limit", "SIZE", "bytes", "0: free memory",
       "size of the grids on host and GPU together, 512M or 1.5GiB; larger ones are drawn in parts",
       &Scene::memory_limit},
  };
}

std::vector<Parameter> make_table() {
  using Group = ParameterGroup;
  const std::pair<Group, Rows> groups[] = {
      {Group::input, input_rows()},       {Group::output, output_rows()},
      {Group::look, look_rows()},         {Group::look, mode_and_part_rows()},
      {Group::light, light_rows()},       {Group::camera, camera_rows()},
      {Group::accuracy, accuracy_rows()}, {Group::machine, machine_rows()}};
  const Scene defaults;
  Rows table;
  for (const auto& [group, rows] : groups) {
    for (Parameter row : rows) {
      row.group = group;
      if (row.default_text.empty()) row.default_text = parameter_text(defaults, row);
      table.push_back(std::move(row));
    }
  }
  std::vector<std::string> names;
  for (const Parameter& row : table)
    if (may_be_of_volume(row)) names.push_back(row.name);
  std::ranges::find(table, "volumes", &Parameter::name)->help += joined(names, ", ");
  return table;
}

}  // namespace

std::string group_name(ParameterGroup group) {
  static constexpr const char* names[] = {"Input",  "Output",   "Look",   "Light",
                                          "Camera", "Accuracy", "Machine"};
  return names[std::size_t(group)];
}

const std::vector<Parameter>& parameters() {
  static const std::vector<Parameter> table = make_table();
  return table;
}

bool may_be_of_volume(const Parameter& parameter) {
  return parameter.of_volume == OfVolume::own || parameter.of_volume == OfVolume::own_or_scenes;
}

bool names_side_grid(const Parameter& parameter) { return parameter.name.ends_with("-grid"); }

const Parameter* find_parameter(std::string_view name) {
  const auto row = std::ranges::find(parameters(), name, &Parameter::name);
  return row == parameters().end() ? nullptr : &*row;
}

}  // namespace psivox
