#include "psivox/open.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "atlas/atlas.h"
#include "base/memory.h"
#include "base/text.h"
#include "base/text_file.h"
#include "field/value_range.h"
#include "look/choices.h"
#include "medium/luminance_sources.h"
#include "medium/map_field.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "scene/json_problem.h"
#include "vdb/grid_names.h"

namespace psivox {
namespace {

// Files of looks

/// A look as its file has it.
struct LookFile {
  Scene scene;                       ///< its parameters: those that are given
  std::vector<std::string> choices;  ///< its list `choose`
};

namespace fs = std::filesystem;

bool is_path(const std::string& name) {
  return name.find('/') != std::string::npos || name.ends_with(".json");
}

/// Where a studio has its looks.
std::vector<std::string> studio_folders() {
  const char* folders = std::getenv("PSIVOX_LOOKS");
  return folders ? split(folders, ':') : std::vector<std::string>();
}

/// The file of that name in those folders.
std::optional<std::string> studio_look(const std::string& name) {
  for (const std::string& folder : studio_folders()) {
    const fs::path path = fs::path(folder) / (name + ".json");
    std::error_code missing;
    if (fs::exists(path, missing)) return path.string();
  }
  return {};
}

LookFile parsed(const std::string& text, const std::string& source) {
  const auto fail = [&](const std::string& what) {
    throw Error(ExitCode::usage, in_quotes(source) + ": " + what);
  };
  nlohmann::json look = shallow_json(text, in_quotes(source), ExitCode::usage, /*throws=*/false);
  if (!look.is_object()) fail("not a look: expected a JSON object of scene parameters");
  LookFile file;
  if (const auto choose = look.find("choose"); choose != look.end()) {
    if (!choose->is_array()) fail("choose: expected a list of names");
    for (const nlohmann::json& item : *choose) {
      const std::string name = item.is_string() ? item.get<std::string>() : item.dump();
      if (const auto known = choice_names(); std::ranges::find(known, name) == known.end())
        fail("choose: " + in_quotes(name) + " is none of " + joined(known, ", "));
      file.choices.push_back(name);
    }
    look.erase(choose);
  }
  for (const char* name : {"input", "look"})
    if (look.contains(name)) fail(std::string(name) + " has no place in a look");
  file.scene = scene_from_json(look.dump(), source);
  return file;
}

/// Throws Error(usage) that lists the looks if there is none of that name, or names what is wrong.
LookFile read_look(const std::string& name) {
  if (name == "plain") return {};
  if (is_path(name)) return parsed(read_text(name, "look"), name);
  if (const auto path = studio_look(name)) return parsed(read_text(*path, "look"), *path);
  for (const auto& [file, text] : embedded_looks())
    if (file == name + ".json") return parsed(std::string(text), file);
  const std::vector<std::string> names = available_looks();
  throw Error(ExitCode::usage, "--look " + in_quotes(name) + ": no such look; there are auto, " +
                                   joined(names, ", ") +
                                   ", the path of a .json, and those in the folders of "
                                   "PSIVOX_LOOKS" +
                                   suggestion(name, names));
}

// The look of a file

/// What a scene says with one of its options. A look leaves it alone.
struct OptionPart {
  std::vector<std::string_view> given;     ///< one of these is enough
  std::vector<std::string_view> replaced;  ///< parameters and choices of a look
};

/// An option replaces its own parameter. These replace more.
const OptionPart parts_of_looks[] = {
    // what says how the medium shines replaces all its sources
    {{"luminance", "luminance-grid", "temperature-grid", "transfer-function"},
     {"luminance", "luminance-grid", "light", "sky", "environment", "colormap", "opacity", "range",
      "balance", "colors", "emission-grid", "flame"}},
    {{"light", "sky", "environment"}, {"light", "sky", "environment"}},
    {{"emission-grid"}, {"flame"}},
    {{"camera-position"}, {"azimuth", "elevation"}},
    {{"ocio", "ocio-display", "ocio-view", "ocio-space"}, {"tone-map"}},
};

bool gives_any(const Scene& scene, const std::vector<std::string_view>& names) {
  return std::ranges::any_of(names, [&](std::string_view name) { return is_given(scene, name); });
}

/// Whether it says how a picture looks; a range, an opacity and an isovalue too.
bool says_how_it_looks(const Parameter& p) {
  if (p.name == "look" || p.name.starts_with("clip") || p.name.starts_with("holdout")) return false;
  return p.group == ParameterGroup::look || p.name == "light" || p.name == "sky" ||
         p.name.starts_with("environment") || p.name == "albedo-grid" || p.name == "background";
}

bool is_level_set(Scene scene, KeptFields& fields) {
  scene.mode = Mode::isosurface;
  return fields.of(scene).density->half_width > 0;
}

/// The name of the look that suits vectors, or one of their components.
std::string look_of_vectors(const Scene& scene, const VectorPart& part, KeptFields& fields) {
  const bool by_value = gives_any(scene, {"colormap", "range", "opacity"});
  if (names_colors(part.grid) && !by_value && (scene.grid.empty() || part.part == "length"))
    return "colors";
  if (part.part == "active") return "smoke";
  return fields.kind(scene).is_signed() ? "signed" : "vectors";
}

/// The same scene, in which values below 0 are kept.
Scene mapped(Scene scene) {
  if (!scene.has_function()) scene.colormap = Colormap::inferno;
  return scene;
}

/// Whether a surface shows the values best, unless the scene says how they look.
bool is_surface(const Scene& scene, FieldKind& kind) {
  return !is_given(scene, "mode") && !gives_any(scene, {"colormap", "range", "opacity"}) &&
         scene.value_scale.is_linear() && kind.is_distance();
}

/// The name of the look that suits values that are no labels, of which some may be below 0, such as
/// air of a CT. A sign alone says nothing: values on both sides of an outside of 0 do, or those
/// that lie about 0 alike where there is no outside.
std::string look_of_signs(const Scene& scene, KeptFields& fields) {
  FieldKind& kind = fields.kind(mapped(scene));
  if (is_surface(scene, kind)) return "surface";
  return kind.is_signed() && kind.is_about_0() ? "signed" : "scan";
}

/// The name of the look that suits a scan.
std::string look_of_scan(const Scene& scene, KeptFields& fields) {
  if (!scene.colormap && fields.kind(mapped(scene)).is_labels()) return "labels";
  return look_of_signs(scene, fields);
}

/// The name of the look that suits a file.
std::string suitable_look(const Scene& scene, KeptFields& fields) {
  const VolumeFile& file = fields.file();
  if (const std::string look = info(scene.mode).look; !look.empty() && look != "auto") {
    if (!scene.shows(Shows::value)) return look;
    return fields.kind(scene).is_labels() ? "labels" : look;
  }
  if (!scene.isovalue.empty()) return "surface";
  const std::string grid = density_grid(scene, file);
  const VectorPart part = vector_part(file, grid);
  if (!part.part.empty()) return look_of_vectors(scene, part, fields);
  const std::string grid_class = file.grid_class(grid);
  if (grid_class == "level set" && !is_given(scene, "mode") && is_level_set(scene, fields))
    return "surface";
  if (grid_class == "scan") return look_of_scan(scene, fields);
  const bool fog = grid_class == "fog volume", named = says_density(grid);
  // as a scan has it: without values below 0 it serves both
  if (!fog) fields.of(mapped(scene));
  const Field& density = *fields.of(scene).density;
  if (density.value_type == "points") return "points";
  if (!scene.colormap && fields.kind(scene).is_labels()) return "labels";
  if (fields.kind(scene).is_signed()) return look_of_signs(scene, fields);
  if (scene.colormap || !scene.value_scale.is_linear()) return "scan";
  if (is_given(scene, "emission-grid") ? !scene.emission_grid.empty()
                                       : !fields.flame(scene).grid.empty())
    return "fire";
  const bool full = !fog && !named && density.active_voxels == count_of(density.active_box);
  FieldKind& kind = fields.kind(scene);
  return kind.is_scan(named && (fog || !kind.is_body()), full) ? "scan" : "smoke";
}

/// Whether the density's values stay in the file: looks need them in memory, all but `plain` and
/// `surface`. A file that is too small for that is not read here: values are 16 times its bytes at
/// most, or 48 times if they are vectors.
bool stays_in_file(const Scene& scene, KeptFields& fields) {
  std::error_code unknown;
  const auto bytes =
      std::uint64_t(std::filesystem::file_size(frame_of_file(scene.input).file, unknown));
  return !unknown && 2 * 48 * bytes > grid_memory(scene) && fields.of(scene).density->reader;
}

/// Labels are never interpolated where a scene has a function or a map of its own either: between 1
/// and 200 lies no 7. On a plane labels and colours are seen in their colours.
void keep_values(const Scene& asked, KeptFields& fields, Scene& scene) {
  const bool plain_plane = asked.shows(Shows::plane) && !asked.has_function() &&
                           !gives_any(asked, {"luminance", "luminance-grid", "temperature-grid"});
  if (is_given(asked, "classification") || !(asked.has_function() || plain_plane)) return;
  const VectorPart part = vector_part(fields.file(), density_grid(asked, fields.file()));
  if (plain_plane && !part.part.empty() && look_of_vectors(asked, part, fields) == "colors") {
    Choosing colors{asked, fields, scene};
    return choose("colors", colors);
  }
  if (!fields.kind(asked).is_labels()) return;
  scene.classification = Classification::nearest;
  if (plain_plane) scene.colormap = Colormap::labels;
}

/// Why the light of a scene takes too much memory; empty: it does not.
std::string too_dark(const Scene& scene, KeptFields& fields) {
  if (!scene.lit()) return {};
  const Field& density = *fields.of(scene).density;
  constexpr double block = 3 * 512 * sizeof(float) + 128;  // of coloured light [bytes]
  if (block * most_visible_blocks(density) < double(grid_memory(scene)) / 2) return {};
  return light_obstacle(make_view(scene, fields.of(scene)));
}

void take_open(const Scene& asked, const Scene& look, bool background, Scene& scene) {
  Scene skyless = asked;  // a sky does not light a surface, and replaces no lamp there
  for (const char* name : {"sky", "environment"}) set_default(skyless, *find_parameter(name));
  for (const Parameter& p : parameters()) {
    const bool lamps = p.name == "light" && look.shows(Shows::surface);
    if (!is_given(look, p) || !leaves_to_look(lamps ? skyless : asked, p.name)) continue;
    if (p.name == "background" && !background) continue;
    // a scene of optical depths has decided about its exposure
    if (p.name == "exposure" && asked.shows(Shows::depth)) continue;
    copy_parameter(look, scene, p);
  }
}

/// Turns the camera to the face of a volume of a single layer of voxels, which is seen edge-on from
/// elsewhere, unless the scene says where it is.
void face_layer(const Scene& asked, const MediumFields& fields, Scene& scene) {
  for (const char* name : {"azimuth", "elevation", "camera-position", "camera-up"})
    if (is_given(asked, name)) return;
  const Field& density = *fields.density;
  const glm::ivec3 size = density.active_box.max - density.active_box.min;
  const int thin = size.x == 0 ? 0 : size.y == 0 ? 1 : 2;
  if (size[thin] != 0 || size[(thin + 1) % 3] == 0 || size[(thin + 2) % 3] == 0) return;
  // its axes in the world of the camera that looks along -z, with y up
  Subject subject;
  subject.z_up = fields.z_up;
  const glm::dvec3 up = up_direction(scene, subject);
  const glm::dvec3 back = up.z > 0 ? glm::dvec3(0, -1, 0) : glm::dvec3(0, 0, 1);
  const glm::dmat3 m(placement(scene, density.world_from_index));
  glm::dvec3 normal = glm::normalize(glm::cross(m[(thin + 1) % 3], m[(thin + 2) % 3]));
  const glm::dvec3 sides(glm::dot(normal, back), glm::dot(normal, up), normal.x);
  constexpr double none = 1e-6;
  const double side = std::abs(sides.x) > none   ? sides.x
                      : std::abs(sides.y) > none ? sides.y
                                                 : sides.z;
  if (side < 0) normal = -normal;
  const double aside = std::abs(sides.x) > none || std::abs(sides.z) > none
                           ? std::atan2(normal.x, glm::dot(normal, back))
                           : 0;
  scene.azimuth = glm::degrees(aside);
  scene.elevation = glm::degrees(std::asin(std::clamp(glm::dot(normal, up), -1.0, 1.0)));
}

std::vector<std::string> unused(const VolumeFile& file, const MediumFields& fields,
                                const Scene& scene) {
  std::vector<std::string> names;
  if (file.metadata().contains("frames")) return names;  // reading names the one that is drawn
  for (const std::string& name : file.names()) {
    if (file.known_to_be_empty(name)) continue;
    bool used = scene.grid == name || scene.grid.starts_with(name + ":");
    const auto is_of = [&](const auto& field) {
      return field && (field->name == name || field->name.starts_with(name + ":"));
    };
    for (const auto& field : {fields.density, fields.luminance, fields.temperature})
      used |= is_of(field);
    for (const EmissionField& emission : fields.emission) used |= is_of(emission.field);
    for (const auto& field : fields.albedo) used |= field->name == name;
    if (!used && file.channels(name) > 0) names.push_back(name);
  }
  return names;
}

/// Whether its world has a patient's right, front and head along x, y and z.
bool is_of_patient(const VolumeFile& file) { return file.z_up().find("scan") != std::string::npos; }

/// Whether the default camera takes Y as up although nothing says so.
bool guesses_up(const Scene& scene, const VolumeFile& file) {
  if (scene.up_axis != UpAxis::automatic || scene.camera_up || scene.camera_position) return false;
  const auto creator = file.metadata().find("creator");
  const bool y_up = creator != file.metadata().end() && creator->second.starts_with("Houdini");
  return !y_up && file.z_up().empty();
}

}  // namespace

std::vector<std::string> look_names() {
  std::vector<std::string> names{"plain"};
  for (const auto& [name, text] : embedded_looks()) names.push_back(name.substr(0, name.find('.')));
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> available_looks() {
  std::vector<std::string> names = look_names();
  for (const std::string& folder : studio_folders()) {
    std::error_code unreadable;
    for (const auto& entry : fs::directory_iterator(folder, unreadable))
      if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

/// Whether what says how the medium shines is the colour of a surface, which keeps its lamps.
bool is_of_surface(const Scene& scene) {
  return scene.shows(Shows::surface) || !scene.isovalue.empty();
}

bool has_bright_background(const Scene& scene) {
  constexpr double bright = 0.4;
  const auto& background = scene.background;
  return background && !background->environment &&
         glm::dot(background->color, glm::dvec3(0.2126, 0.7152, 0.0722)) >= bright;
}

bool leaves_look_open(const Scene& scene) {
  return scene.look.empty() && *info(scene.mode).look &&
         (is_of_surface(scene) || !gives_any(scene, parts_of_looks[0].given));
}

bool leaves_to_look(const Scene& scene, std::string_view name) {
  for (const OptionPart& part : parts_of_looks) {
    const bool kept = &part == parts_of_looks && name == "light" && is_of_surface(scene);
    if (!kept && std::ranges::count(part.replaced, name) && gives_any(scene, part.given))
      return false;
  }
  const Parameter* p = find_parameter(name);
  return !p || !is_given(scene, *p);
}

Scene without_look(Scene scene) {
  if (scene.shows(Shows::depth) && !scene.exposure) scene.exposure = Scene{}.exposure;
  for (const Parameter& p : parameters())
    if (says_how_it_looks(p)) set_default(scene, p);
  set_default(scene, *find_parameter("look"));
  // what only a function or a map may have
  scene.color_bar.reset();
  scene.split_knots = false;
  if (is_transfer_rule(scene.resolved_integrator())) scene.integrator.reset();
  return scene;
}

LookedScene with_look(const Scene& scene, const VolumeFile& file, const std::string& open,
                      bool background, const Parts& parts) {
  limit_claims(scene.memory_limit);
  LookedScene result{scene, scene.look.empty() ? "plain" : scene.look, {}, {}, {}};
  if (leaves_look_open(scene)) result.look = open;
  KeptFields fields(file, parts);
  const bool by_itself = result.look == "auto";
  if (by_itself) {
    file.check_whole();
    const bool surface = is_of_surface(scene);
    if (!surface && parts.allowed && stays_in_file(scene, fields))
      result.dark_because =
          "its values stay in the file, and a look needs them in memory; a larger --memory-limit "
          "holds them";
    result.look = result.dark_because.empty() ? suitable_look(scene, fields) : "plain";
  }
  if (scene.look.empty() && open == "auto") keep_values(scene, fields, result.scene);
  const auto find_darkness = [&] {
    if (by_itself && result.dark_because.empty())
      result.dark_because = too_dark(result.scene, fields);
  };
  const LookFile look = read_look(result.look);
  take_open(scene, look.scene, background, result.scene);
  // a patient is seen from the front, not from behind
  if (is_given(look.scene, "azimuth") && leaves_to_look(scene, "azimuth") && is_of_patient(file))
    result.scene.azimuth += 180;
  find_darkness();
  if (result.dark_because.empty()) {
    if (by_itself) face_layer(scene, fields.of(result.scene), result.scene);
    result.scene.look = "plain";
    Choosing all{scene, fields, result.scene};
    for (const std::string& what : look.choices)
      if (leaves_to_look(scene, what)) choose(what, all);
    result.outside = all.outside;
    find_darkness();  // colours take more
  }
  if (!result.dark_because.empty()) {
    result.scene = scene;
    result.look = "plain";
  }
  result.scene.look = "plain";
  validate(result.scene);
  result.settings = changed_settings(scene, result.scene);
  result.fields = fields.drawn(result.scene);
  result.guesses_up = guesses_up(result.scene, file);
  result.unused_grids = unused(file, result.fields, result.scene);
  return result;
}

}  // namespace psivox
