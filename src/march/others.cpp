#include <algorithm>
#include <glm/matrix.hpp>

#include "march/glsl_subset.h"
#include "march/march_tables.h"
#include "psivox/error.h"

namespace psivox {
namespace {

/// Moves the payloads of a part's page table to where its tables, slots and constants are.
void append_pages(const PageTable& from, int first_slot, int first_constant, PageTable& to) {
  const auto first_page = std::uint32_t(to.entries.size());
  for (const std::uint32_t entry : from.entries) {
    const EntryKind kind = entry_kind(entry);
    std::uint32_t payload = entry_payload(entry);
    if (kind == EntryKind::child) payload += first_page;
    if (kind == EntryKind::constant) payload += std::uint32_t(first_constant);
    if (kind == EntryKind::brick) payload = from.slot(entry) + std::uint32_t(first_slot);
    to.entries.push_back(make_entry(kind, payload));
  }
}

/// One channel of values after the other.
void append_channels(const float* from, std::size_t count, int channels, std::vector<float>& to) {
  for (int c = 0; c < channels; ++c)
    for (std::size_t i = 0; i < count; ++i) to.push_back(from[i * std::size_t(channels) + c]);
}

void append_texels(const BrickAtlas& from, std::vector<float>& texels) {
  append_channels(from.texels.get(), from.bricks.size() * brick_texels, from.channels, texels);
}

}  // namespace

void join_others(const std::vector<OtherBricks>& parts, MediumAtlas& atlas) {
  atlas.others.reset();
  atlas.placed.clear();
  if (parts.empty()) return;
  BrickAtlas all;
  std::vector<float> texels;
  for (const OtherBricks& part : parts) {
    const BrickAtlas& bricks = part.bricks;
    const int channels = bricks.channels + (part.light ? part.light->channels : 0);
    const auto constants = int(bricks.constants.size()) / bricks.channels;
    atlas.placed.push_back({.volume = part.volume,
                            .emits = part.emits,
                            .channels = channels,
                            .domain = bricks.domain,
                            .table_min = bricks.pages.min,
                            .table_size = bricks.pages.top_size,
                            .levels = bricks.pages.levels,
                            .first_page = int(all.pages.entries.size()),
                            .slots = int(bricks.bricks.size()),
                            .constants = constants,
                            .greatest = part.emits ? 0 : greatest_value(bricks)});
    append_pages(bricks.pages, int(all.bricks.size()), int(all.constants.size()), all.pages);
    all.pages.levels = std::max(all.pages.levels, bricks.pages.levels);
    append_channels(bricks.constants.data(), std::size_t(constants), bricks.channels,
                    all.constants);
    for (int c = 0; c < channels; ++c)
      all.bricks.insert(all.bricks.end(), bricks.bricks.begin(), bricks.bricks.end());
    append_texels(bricks, texels);
    if (part.light) append_texels(*part.light, texels);
  }
  // the tables are of float32, which counts as far
  if (all.pages.entries.size() > std::size_t{1} << 24 || all.bricks.size() > std::size_t{1} << 24)
    throw Error(ExitCode::memory, "the volumes of --and have too many bricks; --lod makes fewer");
  all.texels = std::make_shared_for_overwrite<float[]>(texels.size());
  std::ranges::copy(texels, all.texels.get());
  all.size = {.textured_bricks = all.bricks.size(),
              .constant_bricks = all.constants.size(),
              .page_bytes = all.pages.entries.size() * sizeof(std::uint32_t),
              .constant_bytes = all.constants.size() * sizeof(float),
              .texel_bytes = texels.size() * sizeof(float)};
  atlas.others = std::move(all);
}

void place_others(const View& view, const MediumAtlas& atlas, MarchSetup& setup) {
  const Medium& medium = view.medium;
  if (atlas.placed_in(medium).empty()) return;
  std::vector<glm::vec4> entries;
  const auto add_exact = [&](const glm::dvec4& numbers) {
    const glm::vec4 high(numbers);
    entries.push_back(high);
    entries.emplace_back(numbers - glm::dvec4(high));
  };
  // where its voxels are cells, the density's ray runs half a voxel beside it
  const glm::dvec3 from = glm::dvec3(setup.origin) - (setup.constants.nearest ? 0.5 : 0.0);
  bool shine = false;
  for (const PlacedOther& placed : atlas.placed_in(medium)) {
    const Medium& other = medium.others[placed.volume];
    const Emission* const emission = placed.emits ? &other.emission[*placed.emits] : nullptr;
    const Field& field = emission ? *emission->field : *other.density;
    const glm::ivec3 origin = make_ray_bundle(view.camera, field, *medium.density).origin;
    const auto moved = [](const glm::dvec3& by) {
      glm::dmat4 m(1);
      m[3] = glm::dvec4(by, 1);
      return m;
    };
    const glm::dmat4 rows = glm::transpose(moved(-origin) * glm::inverse(field.world_from_index) *
                                           medium.density->world_from_index * moved(from));
    for (int axis = 0; axis < 3; ++axis) add_exact(rows[axis]);
    entries.emplace_back(placed.table_min - origin, placed.levels);
    entries.emplace_back(placed.table_size, placed.first_page);
    entries.emplace_back(placed.domain.min - origin, placed.channels);
    entries.emplace_back(placed.domain.max - origin, 0);
    const double unit = setup.parameters.world_unit;
    entries.emplace_back(emission ? 0 : other.extinction / medium.extinction,
                         emission ? emission->scale * unit : 0, placed.slots, placed.constants);
    const glm::dvec3 own = other.lit ? other.ambient : other.color;
    entries.emplace_back(other.lit ? other.color : glm::dvec3(0), 0);
    entries.emplace_back(own - medium.ambient, 0);
    shine |= emission || other.lit || own != (medium.lit ? medium.ambient : medium.color);
  }
  shine |= medium.source != LuminanceSource::constant;
  setup.parameters.others_first = append(entries, setup);
  setup.constants.other_volumes = int(entries.size()) / other_entries;
  setup.constants.others_levels = atlas.others->pages.levels;
  setup.constants.others_shine = shine;
}

}  // namespace psivox
