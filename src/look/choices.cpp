#include "look/choices.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <optional>
#include <span>
#include <utility>

#include "base/text.h"
#include "field/field_index.h"
#include "field/index_space.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "look/voxel_lines.h"
#include "medium/density_function.h"
#include "medium/map_field.h"
#include "psivox/open.h"
#include "psivox/parameters.h"
#include "vdb/grid_names.h"

namespace psivox {
namespace {

/// The view so far, for the last time.
View take_view(Choosing& all) {
  if (!all.view) {
    View view = make_view(all.scene, all.fields.of(all.scene));
    all.fields.keep(view);
    return view;
  }
  View known = std::move(*all.view);
  all.view.reset();
  return known;
}

/// Optical depth of a voxel of a body, where its opacity is 1.
constexpr double body_depth = 0.7;

void choose_extinction(Choosing& all) {
  if (all.scene.extinction) return;
  View view = take_view(all);
  FieldKind& kind = all.fields.kind(view.medium.density);
  const bool sparse = view.medium.transfer && kind.is_mostly_low();
  const Field& density = *view.medium.density;
  if (!view.medium.nearest) {
    view.medium.extinction = light_extinction(view, sparse);
    // of a body the surface is seen: light reaches a voxel or two of its brightest values
    if (view.medium.transfer && !sparse && kind.is_body())
      view.medium.extinction = std::max(view.medium.extinction, body_depth / finest_voxel(density));
  }
  all.scene.extinction = view.medium.extinction;
  all.view = std::move(view);
}

/// A value around the object that is as far above all others as these are from each other is
/// padding, such as -2000 of a scan in unsigned numbers. Beside it nothing else would be seen.
std::optional<double> padding(FieldKind& kind) {
  const glm::dvec2 range = active_range(*kind.density());
  const std::optional<double> outside = kind.outside();
  if (!outside || *outside != range.y) return {};
  double next = -HUGE_VAL;
  for (const SampledVoxel& some : kind.sample())
    if (double(some.value) < *outside) next = std::max(next, double(some.value));
  const double least = std::min(range.x, 0.0);
  return next > least && *outside - next > next - least ? outside : std::nullopt;
}

/// A label other than 0 may stand for what is around the object, too: 255, -1, or 1 of a
/// classifier.
void leave_out_padding(Choosing& all) {
  FieldKind& kind = all.fields.kind(all.scene);
  if (is_given(all.asked, "fill-value")) return;
  const auto value = kind.is_labels() ? kind.label_outside() : padding(kind);
  if (value.value_or(0) == 0) return;
  all.view.reset();
  all.scene.fill_value = number_text(*value);
}

void choose_range(Choosing& all) {
  all.view.reset();
  if (all.scene.range) return;
  leave_out_padding(all);
  FieldKind& kind = all.fields.kind(all.scene);
  const bool low = kind.is_mostly_low() && !kind.is_veiled();
  set_parameter(all.scene, "range", low ? "50%,99.5%" : "2%,96%");
  const Field& density = *all.fields.of(all.scene).density;
  const glm::dvec2& percent = all.scene.range->ends;
  // almost all values are equal
  if (active_percentile(density, percent.x) >= active_percentile(density, percent.y))
    set_default(all.scene, *find_parameter("range"));
}

/// Cuts off what a map shows beside a box that is full of values: from its outermost voxels they
/// pass to 0, within a voxel, which is a shell around it. An array ends there by itself.
void cut_shell(Choosing& all) {
  const Field& density = *all.fields.of(all.scene).density;
  const Box& box = density.active_box;
  const glm::dmat4 m(placement(all.scene, density.world_from_index));
  const auto is_along = [](const glm::dvec4& axis) {
    return (axis.x != 0) + (axis.y != 0) + (axis.z != 0) == 1;
  };
  if (is_given(all.asked, "clip") || is_given(all.asked, "clip-plane") || density.margin == 0 ||
      all.scene.resolved_sampling() == Sampling::template_ ||
      density.active_voxels != count_of(box) || !glm::all(glm::greaterThan(box.max, box.min)) ||
      !is_along(m[0]) || !is_along(m[1]) || !is_along(m[2]))
    return;
  const auto [first, last] = bounds_of(box, m);
  all.view.reset();
  all.scene.clip = {first, last};
}

/// What fills the volume around the object is transparent, wherever it lies in the range. A veil is
/// seen, thinly.
void choose_opacity(Choosing& all) {
  const Field& density = *all.fields.of(all.scene).density;
  if (!all.scene.opacity || is_given(all.asked, "opacity")) return;
  cut_shell(all);
  if (!is_given(all.asked, "range") && all.fields.kind(all.scene).is_veiled()) {
    all.view.reset();
    all.scene.opacity->points = {{0, 0}, {0.03, 0}, {0.12, 0.06}, {0.4, 0.12}, {1, 1}};
    return;
  }
  const std::optional<double> outside = all.fields.kind(all.scene).outside();
  const std::optional<glm::dvec2> range = resolved_range(all.scene, density);
  if (!outside || !range) return;
  const double u = (*outside - range->x) / (range->y - range->x);
  constexpr double low = 0.2, high = 0.8, near = 0.04, far = 0.16;
  if (u <= low) return;
  all.view.reset();
  all.outside = outside;
  std::vector<glm::dvec2> points;
  if (u >= high) {  // as it is, from the other end
    for (const glm::dvec2& point : all.scene.opacity->points)
      points.insert(points.begin(), {1 - point.x, point.y});
  } else {
    points = {{0, 1}, {u - far, 0.08}, {u - near, 0}, {u + near, 0}, {u + far, 0.08}, {1, 1}};
  }
  all.scene.opacity->points = std::move(points);
}

/// 0 is in the middle of the range.
void choose_balance(Choosing& all) {
  all.view.reset();
  if (all.scene.range) return;
  constexpr double low = 0.5, high = 99.5;
  set_parameter(all.scene, "range", number_text(low) + "%," + number_text(high) + "%");
  const Field& density = *all.fields.of(all.scene).density;
  const double end = std::max(std::abs(active_percentile(density, low)),
                              std::abs(active_percentile(density, high)));
  if (end > 0)
    set_parameter(
        all.scene, "range",
        number_text(density.scale.value_of(-end)) + "," + number_text(density.scale.value_of(end)));
  else
    set_default(all.scene, *find_parameter("range"));
}

void choose_colors(Choosing& all) {
  all.view.reset();
  const VolumeFile& file = all.fields.file();
  const std::string grid = vector_part(file, density_grid(all.scene, file)).grid;
  all.scene.grid = grid + ":active";
  all.scene.luminance_grid = grid;
}

/// Before a bright background smoke is dark, or it would not be seen.
void choose_contrast(Choosing& all) {
  if (!has_bright_background(all.asked) || is_given(all.asked, "albedo")) return;
  all.view.reset();
  all.scene.albedo *= dark_contrast;
  if (all.scene.luminance && !is_given(all.asked, "luminance"))
    *all.scene.luminance *= dark_contrast;
}

/// Bounds of some colours.
struct ColorBounds {
  glm::dvec3 least{HUGE_VAL}, greatest{0};

  void add(const glm::dvec3& color) {
    least = glm::min(least, color);
    greatest = glm::max(greatest, color);
  }
};

ColorBounds bounds_of(const Field& colors) {
  ColorBounds bounds;
  const auto add = [&](const glm::vec3& color) {
    if (color != glm::vec3(0)) bounds.add(glm::dvec3(color));
  };
  for (const Leaf& leaf : colors.leaves) {
    const OrderedValues values(colors, leaf);
    for (std::size_t i = 0; i < 3 * 512; i += 3)
      add({values.data()[i], values.data()[i + 1], values.data()[i + 2]});
  }
  for (const Tile& tile : colors.tiles) add(tile.value);
  return bounds;
}

/// The same of three grids of colour times density.
ColorBounds bounds_of(const MediumFields& fields) {
  ColorBounds bounds;
  const std::vector<FieldIndex> channels{
      FieldIndex(*fields.albedo[0]), FieldIndex(*fields.albedo[1]), FieldIndex(*fields.albedo[2])};
  for (const SampledVoxel& some : sample_voxels(*fields.density, 4096)) {
    glm::dvec3 color;
    for (int c = 0; c < 3; ++c)
      color[c] = channels[std::size_t(c)].at(glm::dvec3(some.voxel)).x / double(some.value);
    bounds.add(color);
  }
  return bounds;
}

/// The hue of colours that are one dark one everywhere: as an albedo it would leave the smoke
/// black, which no simulation means. Unset: they are not.
std::optional<glm::dvec3> dark_hue(const MediumFields& fields) {
  constexpr double dark = 0.5, rounding = 0.02;
  if (fields.albedo.empty()) return {};
  const Field& first = *fields.albedo.front();
  if (fields.albedo.size() == 1 && first.channels != 3) return {};
  const auto [least, greatest] = fields.albedo.size() == 1 ? bounds_of(first) : bounds_of(fields);
  const double most = std::max({greatest.x, greatest.y, greatest.z});
  const glm::dvec3 spread = greatest - least;
  if (!(most > 0 && most < dark) || !(std::max({spread.x, spread.y, spread.z}) <= rounding * most))
    return {};
  return greatest / most;
}

/// A file's colours are what its smoke scatters.
void choose_albedo(Choosing& all) {
  const VolumeFile& file = all.fields.file();
  if (!all.scene.albedo_grid.empty() || !all.scene.lit()) return;
  for (const char* word : color_words) {
    const std::string whole = grid_saying(file, word, 3), name = whole.empty() ? word : whole;
    const std::vector<std::string> grids = albedo_grids(file, name);
    const bool colored = std::ranges::any_of(
        grids, [&](const std::string& grid) { return file.content(grid).nothing.empty(); });
    if (!colored || (grids.size() == 1 && file.channels(name) != 3)) continue;
    all.view.reset();
    all.scene.albedo_grid = name;
    if (is_given(all.asked, "albedo")) return;
    if (const auto hue = dark_hue(all.fields.of(all.scene))) {
      all.scene.albedo_grid.clear();
      all.scene.albedo = *hue;
    }
    return;
  }
}

void choose_flame(Choosing& all) {
  all.view.reset();
  const Flame& flame = all.fields.flame(all.scene);
  if (!flame.grid.empty()) set_flame(all.asked, all.fields.file(), flame, all.scene);
}

/// Distances have their surface at 0. A level set's is there by itself.
void choose_isovalue(Choosing& all) {
  const Field& density = *all.fields.of(all.scene).density;
  if (!all.scene.isovalue.empty() || density.half_width > 0 ||
      !all.fields.kind(all.scene).is_distance())
    return;
  all.view.reset();
  all.scene.isovalue = {{.value = 0}};
}

/// Where distances are below 0 outside, 0 beside them would be another surface.
void choose_sides(Choosing& all) {
  const Field& density = *all.fields.of(all.scene).density;
  FieldKind& kind = all.fields.kind(all.scene);
  if (density.half_width > 0 || !kind.is_distance() || !kind.is_negative_outside()) return;
  all.view.reset();
  if (!is_given(all.asked, "background-value"))
    all.scene.background_value = active_range(density).x;
  cut_shell(all);
}

struct Choice {
  const char* name;
  void (*make)(Choosing&);
};
constexpr Choice choices[] = {{"range", choose_range},           {"outside", choose_opacity},
                              {"balance", choose_balance},       {"colors", choose_colors},
                              {"padding", leave_out_padding},    {"sides", choose_sides},
                              {"extinction", choose_extinction}, {"flame", choose_flame},
                              {"albedo-grid", choose_albedo},    {"contrast", choose_contrast},
                              {"isovalue", choose_isovalue}};

/// Percentages of which looks ask.
constexpr double look_percentiles[] = {0.5, 1, 2, 50, 96, 99, 99.5};

constexpr const char* glowing_words[] = {"flame", "fire", "temperature", "heat", "temp", "fuel"};
constexpr std::size_t flames = 2;
constexpr double coldest = 800, hottest = 2300;  // of what glows [kelvin]
/// Heat above this is in kelvin.
constexpr double least_kelvin = 200;
/// Radiance of the flame's brightest hundredth, in its brightest channel.
constexpr double brightest = 4, bright_part = 0.01;
/// Solvers leave rounding where nothing burns.
constexpr double no_flame = 1e-5;

}  // namespace

const MediumFields& KeptFields::of(const Scene& scene) {
  std::string key = fields_key(scene);
  if (!fields_ || key != key_) {
    KnownDensity known{.percentiles = look_percentiles};
    if (fields_ && !drawn_) {
      known.field = fields_->density;
      known.key = fields_->density_key;
    }
    if (!known.serves(scene)) {
      known.field.reset();
      kind_.reset();
    }
    fields_.reset();  // first, for they may be large
    drawn_.reset();
    fields_ = read_fields(scene, file_, false, parts_, known);
    drawn_ = std::exchange(fields_->drawn, nullptr);
  }
  key_ = std::move(key);
  return *fields_;
}

MediumFields KeptFields::drawn(const Scene& scene) {
  MediumFields fields = of(scene);
  fields.drawn = drawn_;
  return fields;
}

const Flame& KeptFields::flame(const Scene& scene) {
  if (!flame_) flame_ = find_flame(file_, density_grid(scene, file_));
  return *flame_;
}

FieldKind& KeptFields::kind(const std::shared_ptr<const Field>& density) {
  if (!kind_ || kind_->density() != density) kind_.emplace(density);
  return *kind_;
}

std::string density_grid(const Scene& scene, const VolumeFile& file) {
  return scene.grid.empty() ? file.default_grid() : scene.grid;
}

std::vector<std::string> choice_names() { return names_in(choices, &Choice::name); }

void choose(const std::string& name, Choosing& all) {
  std::ranges::find(choices, name, &Choice::name)->make(all);
}

std::string flame_grid(const VolumeFile& file) {
  for (const char* word : std::span(glowing_words).first(flames))
    if (std::string grid = grid_saying(file, word, 1); !grid.empty()) return grid;
  return {};
}

Flame find_flame(const VolumeFile& file, const std::string& density) {
  for (std::size_t n = 0; n < std::size(glowing_words); ++n) {
    const std::string grid = grid_saying(file, glowing_words[n], 1);
    const bool burns = n < flames;
    if (grid.empty() || (grid == density && !burns)) continue;
    // what burns has a flame there
    if (!burns && file.z_up().find("Blender") != std::string::npos) return {};
    const Field field = file.read(grid, {.role = GridRole::data, .empty = true});
    const double greatest = field.active_range ? double(field.active_range->y) : 0;
    const bool kelvin = greatest > (burns ? coldest : least_kelvin);
    if (field.active_voxels && greatest > no_flame && (!kelvin || greatest > coldest))
      return {grid, greatest, kelvin};
    if (burns) return {};  // nothing does
  }
  return {};
}

void set_flame(const Scene& asked, const VolumeFile& file, const Flame& flame, Scene& scene) {
  Scene glowing = scene;
  const auto set = [&](const char* name, auto Scene::*member, const auto& value) {
    if (!is_given(asked, name)) glowing.*member = value;
  };
  set("emission-grid", &Scene::emission_grid, flame.grid);
  set("emission-color", &Scene::emission_color, EmissionColor::black_body);
  // a flame without smoke hides nothing
  if (flame.grid == density_grid(asked, file)) set("extinction", &Scene::extinction, 0.0);
  if (!flame.kelvin) {
    set("temperature-scale", &Scene::temperature_scale, (hottest - coldest) / flame.greatest);
    set("temperature-offset", &Scene::temperature_offset, coldest);
  }
  Scene alone = glowing;
  alone.emission_scale = 1;  // the radiance is proportional to it
  alone.lights.clear();
  alone.sky.reset();
  for (const char* part : {"environment", "environment-rotation", "environment-scale"})
    set_default(alone, *find_parameter(part));
  alone.luminance = glm::dvec3(0);
  const MediumFields fields = read_fields(alone, file);
  double level = glow_level(draft_picture(alone, fields), bright_part);
  if (level == 0) {  // the smoke hides it
    alone.extinction = 0;
    level = glow_level(draft_picture(alone, fields), bright_part);
  }
  if (level == 0) return;
  set("emission-scale", &Scene::emission_scale, brightest / level);
  scene = std::move(glowing);
}

}  // namespace psivox
