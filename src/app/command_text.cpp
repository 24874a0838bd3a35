#include "app/command_text.h"

#include <algorithm>
#include <cmath>
#include <glm/trigonometric.hpp>
#include <map>
#include <utility>

#include "base/text.h"
#include "psivox/open.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

/// What a renderer wants: its lines, in which {name} stands for a number or a vector.
struct Renderer {
  const char* name;
  const char* between;  ///< the numbers of a vector
  const char* head;
  const char* perspective;
  const char* orthographic;
  const char* tail = "";
};

const Renderer renderers[] = {
    {"json", ", ", R"({"camera": {
  "position": [{position}], "target": [{target}],
  "right": [{right}], "up": [{up}], "forward": [{forward}],
  "resolution": [{x}, {y}],)",
     R"( "projection": "perspective",
  "fov": {fov}, "vertical_fov": {vertical_fov}},)",
     R"( "projection": "orthographic",
  "width": {width}, "height": {height}},)",
     "\n\"scene\": {scene}}\n"},
    // pbrt is left-handed; its fov is of the shorter side.
    {"pbrt", " ", "Scale -1 1 1\nLookAt {position}  {target}  {up}\nCamera ",
     R"("perspective" "float fov" [{shorter_fov}])",
     R"("orthographic" "float screenwindow" [-{half_width} {half_width} -{half_height} {half_height}])",
     R"(
Film "rgb" "integer xresolution" [{x}] "integer yresolution" [{y}] "string filename" "picture.exr"
PixelFilter "box" "float xradius" [0.5] "float yradius" [0.5]
)"},
    {"mitsuba", ", ", R"(<sensor type="{projection}">
  <transform name="to_world">
)",
     R"(    <lookat origin="{position}" target="{target}" up="{up}"/>
  </transform>
  <float name="fov" value="{fov}"/> <string name="fov_axis" value="x"/>)",
     R"(    <scale x="{half_width}" y="{half_width}"/>
    <lookat origin="{position}" target="{target}" up="{up}"/>
  </transform>)",
     R"(
  <float name="near_clip" value="{near}"/> <float name="far_clip" value="{far}"/>
  <film type="hdrfilm">
    <integer name="width" value="{x}"/> <integer name="height" value="{y}"/>
    <string name="pixel_format" value="rgba"/> <rfilter type="box"/>
  </film>
</sensor>
)"},
    {"blender", ", ", R"(import bpy
import math
from mathutils import Matrix
scene = bpy.context.scene
camera = bpy.data.objects.new("psivox", bpy.data.cameras.new("psivox"))
scene.collection.objects.link(camera)
scene.camera = camera
# Cycles places a voxel's value in its middle: move the volume's object by ({half_voxel})
axes = Matrix((({right}), ({up}), ({back}))).transposed()
camera.matrix_world = Matrix.Translation(({position})) @ axes.to_4x4()
camera.data.sensor_fit = "HORIZONTAL"
camera.data.clip_start, camera.data.clip_end = {near}, {far}
)",
     "camera.data.angle = math.radians({fov})\n",
     "camera.data.type, camera.data.ortho_scale = \"ORTHO\", {width}\n",
     R"(scene.render.resolution_x, scene.render.resolution_y = {x}, {y}
scene.render.resolution_percentage = 100
scene.render.pixel_aspect_x = scene.render.pixel_aspect_y = 1
)"},
    // It draws constant luminance alone: all light is scattered, none is shadowed.
    {"vdb_render", ",", "vdb_render {file} picture.exr -res {x}x{y} -camera {projection}",
     " -focal 50 -aperture {aperture}", " -frame {width}",
     " -translate {position} -lookat {target} -up {up}{grid}"
     " -absorb 0,0,0 -scatter {per_voxel},{per_voxel},{per_voxel} -light 0,0,1,{luminance} -gain 0"
     " -cutoff 0 -shadowstep 1e9\n"},
    {"paraview", ", ", R"(from paraview.simple import *
view = GetActiveViewOrCreate("RenderView")
view.ViewSize = [{x}, {y}]
view.CameraPosition, view.CameraFocalPoint = [{position}], [{target}]
view.CameraViewUp = [{up}]
)",
     "view.CameraParallelProjection, view.CameraViewAngle = 0, {vertical_fov}\n",
     "view.CameraParallelProjection, view.CameraParallelScale = 1, {half_height}\n"},
};

std::map<std::string, std::string> values_of(const View& view, const char* between) {
  const Camera& camera = view.camera;
  const auto vector = [&](const glm::dvec3& v) {
    return number_text(v.x) + between + number_text(v.y) + between + number_text(v.z);
  };
  const auto degrees = [](double half) { return 2 * glm::degrees(std::atan(half)); };
  const double distance = glm::distance(camera.position, camera.target);
  const glm::dmat4& world = view.medium.density->world_from_index;
  const bool at_corner = view.scene.centering == Centering::node;
  std::map<std::string, std::string> values = {
      {"half_voxel",
       vector(at_corner ? -0.5 * glm::dvec3(world[0] + world[1] + world[2]) : glm::dvec3(0))},
      {"position", vector(camera.position)},
      {"target", vector(camera.position + distance * camera.forward)},
      {"right", vector(camera.right)},
      {"up", vector(camera.up)},
      {"forward", vector(camera.forward)},
      {"back", vector(-camera.forward)},
      {"projection", camera.orthographic ? "orthographic" : "perspective"},
      {"x", std::to_string(view.scene.resolution.x)},
      {"y", std::to_string(view.scene.resolution.y)},
      {"file", shell_word(view.scene.input)},
      {"grid", view.scene.grid.empty() ? "" : " -name " + shell_word(view.scene.grid)},
      {"luminance", vector(view.scene.resolved_luminance())},
      {"scene", to_json(view.scene)}};
  const std::pair<const char*, double> numbers[] = {
      {"fov", degrees(camera.half_width)},
      {"vertical_fov", degrees(camera.half_height)},
      {"shorter_fov", degrees(std::min(camera.half_width, camera.half_height))},
      {"aperture", 100 * camera.half_width},
      {"half_width", camera.half_width},
      {"half_height", camera.half_height},
      {"width", 2 * camera.half_width},
      {"height", 2 * camera.half_height},
      {"per_voxel", view.medium.extinction * glm::length(glm::dvec3(world[0]))},
      {"near", 1e-3 * distance},
      {"far", 1e3 * distance}};
  for (const auto& [name, value] : numbers) values[name] = number_text(value);
  return values;
}

}  // namespace

std::vector<std::string> render_arguments(const Scene& scene, const std::string& output) {
  std::vector<Setting> settings;
  for (const Parameter& p : parameters())
    if (!p.positional && !has_default(scene, p))
      settings.push_back({p.name, parameter_text(scene, p)});
  // defaults that the command line would replace are named too
  Scene read;
  apply_over(read, settings);
  for (const Parameter& p : parameters())
    if (!p.positional && has_default(scene, p) && !has_default(read, p))
      settings.push_back({p.name, parameter_text(scene, p)});
  // the scene is what is shown: nothing is left to a look
  if (leaves_look_open(scene)) settings.push_back({"look", "plain"});
  const bool like_an_option = scene.input.starts_with('-');
  std::vector<std::string> arguments = {(like_an_option ? "./" : "") + scene.input,
                                        "--output=" + output};
  for (const auto& [name, text] : settings) arguments.push_back("--" + name + "=" + text);
  return arguments;
}

std::string render_command_line(const Scene& scene, const std::string& output) {
  std::string line = "psivox render";
  for (const std::string& word : render_arguments(scene, output)) line += " " + shell_word(word);
  return line;
}

std::vector<std::string> camera_line_formats() { return names_in(renderers, &Renderer::name); }

std::string camera_lines(const View& view, const std::string& format) {
  const Renderer& renderer = *std::ranges::find(renderers, format, &Renderer::name);
  std::string lines = renderer.head;
  lines += view.camera.orthographic ? renderer.orthographic : renderer.perspective;
  lines += renderer.tail;
  for (const auto& [name, value] : values_of(view, renderer.between)) {
    const std::string place = "{" + name + "}";
    for (std::size_t at = 0; (at = lines.find(place, at)) != lines.npos; at += value.size())
      lines.replace(at, place.size(), value);
  }
  return lines;
}

std::string option_of_concept(std::string_view name) {
  static constexpr std::pair<std::string_view, std::string_view> concepts[] = {
      {"--albedo", "scattering"},
      {"--aov", "layers passes"},
      {"--axes", "orientation triad"},
      {"--background", "backdrop bg"},
      {"--box", "bounds outline"},
      {"--camera-position", "eye from translate"},
      {"--camera-target", "lookat"},
      {"--clip", "crop cut"},
      {"--color-bar", "legend scalar-bar"},
      {"--colormap", "color lut palette"},
      {"--device", "gpu"},
      {"--exposure", "brightness gain gamma"},
      {"--extinction", "absorb density"},
      {"--grid", "field scalars variable"},
      {"--isovalue", "contour threshold"},
      {"--light", "shadow sun"},
      {"--look", "preset style"},
      {"--mode", "plane plot"},
      {"--opacity", "alpha"},
      {"--output", "output-file"},
      {"--pixel-samples", "rays samples spp"},
      {"--range", "level levels volume-range window"},
      {"--resolution", "dimensions height size width"},
      {"--slice", "slice-axis slice-position"},
      {"--title", "caption"},
      {"--tone-map", "tonemap"},
      {"--value-scale", "log log-scale symlog"},
  };
  if (!name.starts_with("--")) return "";
  for (const auto& [option, names] : concepts)
    if (std::ranges::count(split(names, ' '), name.substr(2)) > 0) return std::string(option);
  return "";
}

}  // namespace psivox
