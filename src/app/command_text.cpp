#include "app/command_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/trigonometric.hpp>
#include <sstream>
#include <utility>

#include "base/text.h"
#include "psivox/open.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

/// What {name} stands for in a template: numbers and texts. Of a vector {name} has ", " between the
/// numbers, and {name:,} and {name: } have "," and " ".
std::map<std::string, std::string> values_of(const View& view) {
  const Camera& camera = view.camera;
  const auto degrees = [](double half) { return 2 * glm::degrees(std::atan(half)); };
  const double distance = glm::distance(camera.position, camera.target);
  const glm::dmat4& world = view.medium.density->world_from_index;
  const bool at_corner = view.scene.centering == Centering::node;
  std::map<std::string, std::string> values = {
      {"projection", camera.orthographic ? "orthographic" : "perspective"},
      {"x", std::to_string(view.scene.resolution.x)},
      {"y", std::to_string(view.scene.resolution.y)},
      {"file", shell_word(view.scene.input)},
      {"grid", view.scene.grid.empty() ? "" : " -name " + shell_word(view.scene.grid)},
      {"scene", to_json(view.scene)}};
  const std::pair<std::string, glm::dvec3> vectors[] = {
      {"half_voxel", at_corner ? -0.5 * glm::dvec3(world[0] + world[1] + world[2]) : glm::dvec3(0)},
      {"position", camera.position},
      {"target", camera.position + distance * camera.forward},
      {"right", camera.right},
      {"up", camera.up},
      {"forward", camera.forward},
      {"back", -camera.forward},
      {"luminance", view.scene.resolved_luminance()}};
  for (const auto& [name, v] : vectors)
    for (const std::string between : {"", ",", " "})
      values[name + (between.empty() ? "" : ":") + between] =
          joined(std::array{number_text(v.x), number_text(v.y), number_text(v.z)},
                 between.empty() ? ", " : between);
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

std::vector<std::string> camera_line_formats() {
  return names_in(camera_templates(), &std::pair<const std::string, std::string>::first);
}

std::string camera_lines(const View& view, const std::string& format) {
  std::map<std::string, std::string> values = values_of(view);
  const std::string own = "@" + values["projection"] + " ";
  std::string lines;
  std::istringstream all(camera_templates().at(format));
  for (std::string line; std::getline(all, line);) {
    if (line.starts_with('@') && !line.starts_with(own)) continue;
    lines += line.substr(line.starts_with('@') ? own.size() : 0);
    if (line.ends_with('\\'))
      lines.pop_back();
    else
      lines += '\n';
  }
  for (const auto& [name, value] : values) {
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
