#include "psivox/look.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "look/draft.h"
#include "look/file_kind.h"
#include "look/flame.h"
#include "look/light_extinction.h"
#include "look/look_file.h"
#include "psivox/atlas.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/parts.h"
#include "psivox/text.h"
#include "scene/rank_leaves.h"
#include "scene/value_range.h"
#include "scene/vector_part.h"

namespace psivox {
namespace {

/// Whether it cuts a part of the volume off.
bool cuts(const Parameter& p) { return p.name == "clip" || p.name == "clip-plane"; }

/// Whether it says which values are shown, in any look.
bool windows(const Parameter& p) {
  return p.name == "range" || p.name == "opacity" || p.name == "isovalue";
}

bool says_how_it_looks(const Parameter& p) {
  if (p.name == "look" || p.name == "extinction") return false;
  return p.group == ParameterGroup::look || p.name == "light" || p.name == "sky" ||
         p.name == "background";
}

std::string density_grid(const Scene& scene, const VdbFile& file) {
  return scene.grid.empty() ? file.default_grid() : scene.grid;
}

/// Fields of a file, read again only for a scene that needs others.
class KeptFields {
 public:
  KeptFields(const VdbFile& file, const Parts& parts) : file_(file), parts_(parts) {}
  const MediumFields& of(const Scene& scene) {
    std::string key = fields_key(scene);
    if (!fields_ || key != key_) fields_ = read_fields(scene, file_, false, parts_);
    key_ = std::move(key);
    return *fields_;
  }

 private:
  const VdbFile& file_;
  const Parts& parts_;
  std::optional<MediumFields> fields_;
  std::string key_;
};

/// Whether a grid of the class is a level set, and not a fog that some program gave the class.
bool is_surface(Scene scene, KeptFields& fields) {
  scene.mode = Mode::isosurface;
  return fields.of(scene).density->half_width > 0;
}

/// The name of the look that suits a file; the density is read only where its values decide.
std::string suitable_look(const Scene& scene, const VdbFile& file, KeptFields& fields) {
  if (scene.mode == Mode::xray) return "xray";
  const std::string grid = density_grid(scene, file);
  const VectorPart part = vector_part(file, grid);
  // a component has two signs, and a map for them
  if (!part.part.empty()) return part.part == "length" ? "vectors" : "plain";
  if (file.channels(grid) != 1) return "plain";
  if (file.grid_class(grid) == "level set" && is_surface(scene, fields)) return "surface";
  if (!flame_grid(file, grid).empty()) return "fire";
  return is_scan(*fields.of(scene).density) ? "scan" : "smoke";
}

/// Whether the density's values stay in the file: looks need them in memory, all but `plain`. A
/// file that is too small for that is not read here: values are 16 times its bytes at most, or 48
/// times if they are vectors.
bool stays_in_file(const Scene& scene, KeptFields& fields) {
  std::error_code unknown;
  const auto bytes = std::uint64_t(std::filesystem::file_size(scene.input, unknown));
  return !unknown && 2 * 48 * bytes > grid_memory(scene) && fields.of(scene).density->reader;
}

/// Why the light of a scene takes too much memory; empty: it does not.
std::string too_dark(const Scene& scene, KeptFields& fields) {
  if (!scene.lit()) return {};
  const Field& density = *fields.of(scene).density;
  constexpr double block = 3 * 512 * sizeof(float) + 128;  // of coloured light [bytes]
  if (block * most_visible_blocks(density) < double(grid_memory(scene)) / 2) return {};
  return light_obstacle(make_view(scene, fields.of(scene)));
}

void take_open(const Scene& look, bool background, Scene& scene) {
  for (const Parameter& p : parameters()) {
    if (has_default(look, p) || !has_default(scene, p)) continue;
    if (p.name == "background" && !background) continue;
    // a scene of that mode has decided about its exposure
    if (p.name == "exposure" && scene.mode == Mode::xray) continue;
    std::visit([&](auto member) { scene.*member = look.*member; }, p.member);
  }
}

/// Scales light and luminance so that the mean luminance of what is covered is as wanted, or less
/// where 3 % would be brighter than white.
void set_brightness(KeptFields& fields, const View& view, Scene& scene) {
  constexpr double wanted_mean = 0.25, white = 0.95, highlights = 0.03;
  const std::optional<Draft> by_rays = ray_draft(view);
  if (!by_rays && is_shared(*view.medium.density))
    throw Error(ExitCode::usage,
                "several processes choose the brightness of a look without --sky, --phase-g,"
                " emission and functions of the gradient only: start one process, or give the"
                " options that --print-scene of one prints");
  const Draft draft = by_rays ? *by_rays : make_draft(scene, fields.of(scene));
  if (!(draft.mean_luminance() > 0)) return;
  const double gain =
      std::min(wanted_mean / draft.mean_luminance(), white / draft.level(highlights));
  for (DirectionalLight& light : scene.lights) light.color *= gain;
  if (scene.luminance) *scene.luminance *= gain;
}

/// `view`: the scene's, or nothing if it is not known; making it takes longer than most choices.
void choose(const std::string& what, const VdbFile& file, KeptFields& fields,
            std::optional<View>& view, Scene& scene) {
  std::optional<View> known = std::move(view);
  view.reset();
  if (what == "flame") {
    const std::string grid = flame_grid(file, density_grid(scene, file));
    if (!grid.empty() && scene.emission_grid.empty()) set_flame(scene, file, grid);
  } else if (what == "range") {
    if (scene.range) return;
    set_parameter(scene, "range",
                  is_mostly_low(*fields.of(scene).density) ? "50%,99.5%" : "2%,96%");
    const Field& density = *fields.of(scene).density;
    const glm::dvec2& percent = scene.range->ends;
    // almost all values are equal
    if (active_percentile(density, percent.x) >= active_percentile(density, percent.y))
      scene.range.reset();
  } else if (what == "brightness") {
    set_brightness(fields, known ? *known : make_view(scene, fields.of(scene)), scene);
  } else if (!scene.extinction) {
    view = known ? std::move(*known) : make_view(scene, fields.of(scene));
    const bool sparse = view->medium.transfer && is_mostly_low(*view->medium.density);
    scene.extinction = view->medium.extinction = light_extinction(*view, sparse);
  }
}

std::vector<std::string> unused(const VdbFile& file, const MediumFields& fields,
                                const Scene& scene) {
  std::vector<std::string> names;
  for (const std::string& name : file.names()) {
    bool used = scene.grid == name || scene.grid.starts_with(name + ":");
    for (const auto& field :
         {fields.density, fields.luminance, fields.temperature, fields.emission})
      used |= field && (field->name == name || field->name.starts_with(name + ":"));
    if (!used && file.channels(name) > 0) names.push_back(name);
  }
  return names;
}

}  // namespace

bool leaves_look_open(const Scene& scene) {
  if (!scene.look.empty()) return false;
  return std::all_of(parameters().begin(), parameters().end(), [&](const Parameter& p) {
    return !says_how_it_looks(p) || cuts(p) || windows(p) || has_default(scene, p) ||
           (p.name == "mode" && scene.mode == Mode::xray);
  });
}

Scene without_look(Scene scene) {
  if (scene.mode == Mode::xray && !scene.exposure) scene.exposure = Scene{}.exposure;
  for (const Parameter& p : parameters())
    if (says_how_it_looks(p) && !cuts(p)) set_default(scene, p);
  scene.extinction.reset();
  scene.look.clear();
  // what only a function or a map may have
  scene.color_bar = scene.split_knots = false;
  if (is_transfer_rule(scene.resolved_integrator())) scene.integrator.reset();
  return scene;
}

LookedScene with_look(const Scene& scene, const VdbFile& file, const std::string& open,
                      bool background, const Parts& parts) {
  LookedScene result{scene, scene.look.empty() ? "plain" : scene.look, {}, {}, {}};
  if (leaves_look_open(scene)) result.look = open;
  KeptFields fields(file, parts);
  const bool by_itself = result.look == "auto";
  if (by_itself) {
    const bool out_of_reach = parts.allowed && !parts.ranks && stays_in_file(scene, fields);
    result.look = out_of_reach ? "plain" : suitable_look(scene, file, fields);
  }
  LookFile look = read_look(result.look);
  take_open(look.scene, background, result.scene);
  if (by_itself && !parts.ranks) result.dark_because = too_dark(result.scene, fields);
  if (!result.dark_because.empty()) {
    result.scene = scene;
    result.look = "plain";
    look = read_look(result.look);
    take_open(look.scene, background, result.scene);
  }
  result.scene.look = "plain";
  std::optional<View> view;
  for (const std::string& what : look.choices) choose(what, file, fields, view, result.scene);
  validate(result.scene);
  result.settings = changed_settings(scene, result.scene);
  result.fields = fields.of(result.scene);
  result.unused_grids = unused(file, result.fields, result.scene);
  return result;
}

}  // namespace psivox
