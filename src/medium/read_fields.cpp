#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "base/memory.h"
#include "base/text.h"
#include "field/index_space.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "medium/luminance_sources.h"
#include "medium/map_field.h"
#include "psivox/medium.h"
#include "psivox/parameters.h"
#include "scene/enum_names.h"
#include "vdb/grid_names.h"
#include "vdb/reading_messages.h"

namespace psivox {
namespace {

/// What psivox takes without grids, most of it the code of libraries and Mesa's software driver
/// with its compiler, and what a picture in parts takes on host and GPU for each pixel [bytes].
/// Measured; see docs/performance.md.
constexpr std::uint64_t of_program = 168 << 20, of_pixel = 80;
/// Grids may always take this much, or the whole limit if that is smaller [bytes].
constexpr std::uint64_t least_memory = 32 << 20;

/// The modes in which a volume can be drawn in parts, for a message.
std::string modes_in_parts() {
  const std::vector<std::string> all = enum_names(Mode{});
  std::vector<std::string> names;
  for (const ModeInfo& row : mode_rows)
    if (row.in_parts) names.push_back(all[std::size_t(row.id)]);
  const std::string last = names.back();
  names.pop_back();
  return joined(names, ", ") + " and " + last;
}

/// Whether several processes draw the volume together.
bool is_shared(const Parts& parts) { return parts.team->size() > 1; }

/// A text that differs, in all likelihood, between fields of different leaves.
std::string topology_of(const Field& field) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a
  for (const Leaf& leaf : field.leaves)
    for (int axis = 0; axis < 3; ++axis)
      hash = (hash ^ std::uint32_t(leaf.origin[axis])) * 1099511628211u;
  return std::to_string(hash) + " " + std::to_string(field.active_voxels);
}

/// How often an overview is halved to have so many leaves at most.
int overview_level(const Field& field, std::size_t most) {
  std::vector<glm::ivec3> places;
  for (const Leaf& leaf : field.leaves) places.push_back(leaf.origin >> 3);
  int level = 0;
  for (; places.size() > most; ++level) {
    for (glm::ivec3& place : places) place >>= 1;
    std::ranges::sort(places, comes_before);
    const auto same = std::ranges::unique(places);
    places.erase(same.begin(), same.end());
  }
  return level;
}

/// The field by which a team chooses a view of a density whose values stay in the file: the density
/// itself if it has few leaves, else a sample of its voxels. `memory`: that it and its atlas may
/// take [bytes]; 0: not known.
Field overview_of(const Field& stored, Centering centering, std::uint64_t memory) {
  std::size_t most_leaves = std::size_t{1} << 14;  // 32 MiB of scalars
  // an atlas on host and GPU has 5.7 KiB for the 2 KiB of a leaf
  const std::uint64_t leaf_bytes = 4 * 512 * sizeof(float) * std::uint64_t(stored.channels);
  while (most_leaves > 8 && memory > 0 && leaf_bytes * most_leaves > memory) most_leaves /= 2;
  const int level = overview_level(stored, most_leaves);
  return level > 0 ? coarse_field(stored, level, centering, CoarseValue::sample)
                   : part_of_field(stored, everywhere);
}

/// Gives all members of a team the first one's field: what it is, its leaves and tiles, and values
/// unless they stay in the file.
void take_first(Field& field, Team& team) {
  if (team.size() == 1) return;
  std::vector<float> values;
  if (team.first() && !field.reader)
    for (const Leaf& leaf : field.leaves) {
      const OrderedValues own(field, leaf);
      values.insert(values.end(), own.begin(), own.end());
    }
  const std::string first = team.gather(team.first() ? guard::packed(field, values) : "").front();
  if (team.first()) return;
  guard::unpack(first, field, values);
  if (values.empty()) return;
  field.reader = {};
  fill_leaves(field, [&](std::size_t n, float* to) {
    const std::size_t floats = values.size() / field.leaves.size();
    std::copy_n(values.begin() + std::ptrdiff_t(n * floats), floats, to);
  });
}

/// The field with a notice.
std::shared_ptr<const Field> noted(Field field, const std::string& what) {
  field.notices.push_back("grid " + in_quotes(field.name) + ": " + what);
  return std::make_shared<const Field>(std::move(field));
}

/// The field at the scene's level of detail, which it may have already.
std::shared_ptr<const Field> at_level(const Scene& scene, Field field, bool is_coarse = false) {
  if (scene.lod == 0) return std::make_shared<const Field>(std::move(field));
  Field coarse = is_coarse ? std::move(field) : coarse_field(field, scene.lod, scene.centering);
  const std::string width = std::to_string(1 << scene.lod);
  coarse.notices.push_back("grid '" + coarse.name + "': --lod " + std::to_string(scene.lod) +
                           " makes one voxel of " + width + "x" + width + "x" + width);
  return std::make_shared<const Field>(std::move(coarse));
}

std::shared_ptr<const Field> read(const Scene& scene, const VolumeFile& file,
                                  const std::string& grid, const ReadOptions& options) {
  Field field = file.read(grid, options);
  if (options.role == GridRole::luminance) field = linear_colors(std::move(field));
  return at_level(scene, std::move(field));
}

ReadOptions options_of(const Scene& scene, GridRole role, bool empty) {
  return {
      .role = role, .strict = scene.strict, .empty = empty, .background = scene.background_value};
}

/// The percentages of the scene's range.
std::vector<double> range_percentiles(const Scene& scene) {
  std::vector<double> percents;
  for (int i = 0; scene.range && i < 2; ++i)
    if (scene.range->percent[i]) percents.push_back(scene.range->ends[i]);
  return percents;
}

Field read_scalar_density(const Scene& scene, const VolumeFile& file, const std::string& name,
                          ReadOptions& options, const Parts& parts) {
  options.distances = scene.shows(Shows::surface);
  for (const double percent : range_percentiles(scene)) options.percentiles.push_back(percent);
  if (parts.allowed && parts_obstacle(scene).empty() && scene.renderer != RendererKind::reference)
    options.memory = grid_memory(scene) / 2;
  options.in_file = is_shared(parts);
  options.survey = parts.team->first();
  return file.read(name, options);
}

/// What to say if whole numbers are larger than float32 tells apart; else empty.
std::string lost_identity(const Field& field) {
  constexpr double most = 1 << 24;
  const std::string& type = field.value_type;
  if (type.find("int32") == type.npos && type.find("int64") == type.npos) return "";
  const glm::dvec2 range = stored_range(field);
  if (std::max(-range.x, range.y) <= most) return "";
  return "grid " + in_quotes(field.name) +
         ": its whole numbers above 16777216 are rounded to those that float32 has";
}

/// Whether values below 0 stay: those that a function maps, and those of a surface or a plane.
bool reads_data(const Scene& scene) {
  return scene.has_function() || scene.shows(Shows::surface) || scene.shows(Shows::plane);
}

/// What the density of a scene follows from, but for percentiles. `data`: values below 0 stay.
std::string density_key(const Scene& scene, bool data) {
  std::string key = data ? "data" : "";
  for (const char* name :
       {"input", "grid", "strict", "background-value", "fill-value", "lod", "value-scale"})
    key += "\n" + parameter_text(scene, name);
  if (scene.lod) key += "\n" + parameter_text(scene, "centering");
  return key + (scene.shows(Shows::surface) ? "\ndistances" : "");
}

Field read_density(const Scene& scene, const VolumeFile& file, const std::string& name, bool data,
                   bool empty, const Parts& parts, std::span<const double> percentiles) {
  const VectorPart part = vector_part(file, name);
  ReadOptions options =
      options_of(scene, data || part.of_vectors() ? GridRole::data : GridRole::attenuation, empty);
  options.active = part.active();
  options.absent = !part.of_vectors();
  options.fill = scene.fill_value == "auto";
  if (scene.fill_value != "auto" && scene.fill_value != "none")
    options.fill_value = float(std::stod(scene.fill_value));
  // those of vectors would be of their first component
  if (data && !part.of_vectors())
    options.percentiles.assign(percentiles.begin(), percentiles.end());
  Field field = part.of_vectors() ? part_of_vectors(file.read(part.grid, options), part)
                                  : read_scalar_density(scene, file, part.grid, options, parts);
  parts.team->check_same(topology_of(field), "sees another volume");
  if (field.reader) take_first(field, *parts.team);
  if (field.reader && scene.lod == 0 && !is_shared(parts)) {
    field.notices.push_back("grid '" + field.name + "': its values, " +
                            mebibytes(value_bytes(field)) + ", stay in the file");
  }
  field.stored_range = glm::vec2(stored_range(field));  // of a part of vectors it is not known
  if (std::string identity = lost_identity(field); !identity.empty())
    field.notices.push_back(std::move(identity));
  return field;
}

/// Sets the density of the fields, and what is drawn in its place.
void set_density(const Scene& scene, const VolumeFile& file, const std::string& grid, bool data,
                 bool empty, const Parts& parts, std::span<const double> percentiles,
                 MediumFields& fields) {
  Field density = read_density(scene, file, grid, data, empty, parts, percentiles);
  if (scene.grid.empty() && file.names().size() > 1 && lower_case(grid) != "density" &&
      !file.metadata().contains("frames"))
    density.notices.push_back("grid " + in_quotes(grid) + " of " +
                              std::to_string(file.names().size()) +
                              "; --grid NAME chooses another");
  const bool chosen_by_first = is_shared(parts) && density.reader;
  if (density.reader && scene.lod == 0)
    density = *scaled_values(std::make_shared<const Field>(std::move(density)), scene.value_scale,
                             *parts.team);
  if (chosen_by_first) {
    // members on one machine share what is free there; a limit is each process's
    const int sharing = scene.memory_limit ? 1 : parts.team->place().local_size;
    const std::uint64_t memory = grid_memory(scene) / std::uint64_t(sharing);
    Field overview;
    if (parts.team->first())
      overview = scene.lod > 0 ? coarse_field(density, scene.lod, scene.centering)
                               : overview_of(density, scene.centering, memory);
    if (scene.lod == 0) fields.drawn = std::make_shared<const Field>(std::move(density));
    take_first(overview, *parts.team);
    density = std::move(overview);
  }
  fields.density =
      scaled_values(at_level(scene, std::move(density), chosen_by_first), scene.value_scale);
}

}  // namespace

std::string parts_obstacle(const Scene& scene) {
  if (!info(scene.mode).in_parts) return "--mode " + modes_in_parts();
  if (scene.resolved_sampling() == Sampling::template_) return "--sampling cells and uniform";
  if (!scene.volumes.empty()) return "volumes without --and";
  return {};
}

std::uint64_t grid_memory(const Scene& scene) {
  const std::uint64_t limit = scene.memory_limit;
  if (limit == 0) return available_memory() / 5 * 4;
  const auto pixels = std::uint64_t(scene.resolution.x) * std::uint64_t(scene.resolution.y);
  const std::uint64_t others = of_program + of_pixel * pixels;
  return std::max(limit > others ? limit - others : 0, std::min(limit, least_memory));
}

bool KnownDensity::serves(const Scene& scene) const {
  if (!field || field->reader) return false;
  const bool data = reads_data(scene);
  // without values below 0 data attenuates as it is, but an array of data may have another domain
  const bool positive = field->stored_range && field->stored_range->x >= 0 && !field->array_box;
  if (key != density_key(scene, data) && !(!data && positive && key == density_key(scene, true)))
    return false;
  return std::ranges::all_of(range_percentiles(scene), [&](double percent) {
    return field->active_percentiles.contains(percent);
  });
}

MediumFields read_fields(const Scene& scene, const VolumeFile& file, bool empty, const Parts& parts,
                         const KnownDensity& known) {
  MediumFields fields;
  fields.z_up = file.z_up();
  const bool data = reads_data(scene);
  const std::string grid = scene.grid.empty() ? file.default_grid(empty) : scene.grid;
  // a density that is empty is chosen where other grids are none to draw
  if (scene.grid.empty() && file.names().size() > 1 && !empty) empty = !file.holds_something(grid);
  fields.density = known.field;
  fields.density_key = known.field ? known.key : density_key(scene, data);
  if (!known.field) set_density(scene, file, grid, data, empty, parts, known.percentiles, fields);
  if (!scene.composites() && !scene.shines()) return fields;

  // A grid that is also the density is read once, unless a function maps the density, whose values
  // may then be negative. One grid may have two names: `density` is also `density[0]`.
  const auto luminance = [&](const std::string& name) {
    if (name == grid && !data && !fields.density->of_vectors) return fields.density;
    auto field = read(scene, file, name, options_of(scene, GridRole::luminance, empty));
    if (fields.density->name == field->name + ":active" && !fields.density->reader)
      return std::make_shared<const Field>(spread_colors(*field, *fields.density));
    return field->name == fields.density->name && !data ? fields.density : field;
  };
  if (scene.shines() && !scene.luminance_grid.empty()) {
    fields.luminance = luminance(scene.luminance_grid);
    if (scene.lit() && fields.luminance->world_from_index != fields.density->world_from_index)
      fields.luminance =
          noted(*fields.luminance, "beside light, its luminance is taken at the density's voxels");
  }
  for (const EmissionOptions& emission : emission_options) {
    const std::string& name = scene.*emission.grid;
    if (name.empty() || !(scene.*emission.scale > 0) || !scene.composites()) continue;
    // an overview would be drawn as it is
    fields.emission.push_back(
        {&emission, fields.drawn
                        ? read(scene, file, name, options_of(scene, GridRole::luminance, empty))
                        : luminance(name)});
  }
  if (scene.shines() && !scene.temperature_grid.empty())
    fields.temperature =
        read(scene, file, scene.temperature_grid, options_of(scene, GridRole::data, empty));
  if (scene.lit() && !scene.albedo_grid.empty()) {
    std::vector<std::string> names = albedo_grids(file, scene.albedo_grid);
    if (names.empty()) names = {scene.albedo_grid};  // which reading refuses
    for (const std::string& name : names)
      fields.albedo.push_back(
          read(scene, file, name, options_of(scene, GridRole::luminance, empty)));
  }
  return fields;
}

void read_volumes(const Scene& scene, MediumFields& fields) {
  while (fields.others.size() < scene.volumes.size()) {
    const Scene own = scene_of_volume(scene, scene.volumes[fields.others.size()]);
    fields.others.push_back(read_fields(own, VolumeFile(own.input)));
  }
}

std::vector<std::string> albedo_grids(const VolumeFile& file, const std::string& name) {
  if (file.channels(name) > 0) return {name};
  std::vector<std::string> names;
  for (const char* channel : {"r", "g", "b"}) {
    std::vector<std::string> words = name_words(name);
    words.emplace_back(channel);
    for (const std::string& grid : file.names())
      if (name_words(grid) == words && file.channels(grid) == 1) {
        names.push_back(grid);
        break;
      }
  }
  return names.size() == 3 ? names : std::vector<std::string>{};
}

std::string fields_key(const Scene& scene) {
  std::string key = density_key(scene, reads_data(scene));
  for (const char* name : {"luminance-grid", "temperature-grid", "albedo-grid", "volumes"})
    key += "\n" + parameter_text(scene, name);
  for (const EmissionOptions& emission : emission_options)
    key += "\n" + (scene.*emission.scale > 0 ? scene.*emission.grid : "");
  if (scene.range && (scene.range->percent.x || scene.range->percent.y))
    key += "\n" + parameter_text(scene, "range");
  for (const bool choice : {scene.composites(), scene.shines(), scene.lit()})
    key += choice ? "1" : "0";
  return key;
}

}  // namespace psivox
