#include "draw/part_marcher.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/text.h"
#include "field/leaf_values.h"
#include "march/grids.h"
#include "march/medium_atlas.h"
#include "psivox/error.h"
#include "psivox/medium.h"

namespace psivox {
namespace {

/// Which pictures parts allow, for a message (`pictures without layer error`); empty if this one
/// is allowed.
std::string region_obstacle(const View& view, const Wish& wish) {
  if (std::string obstacle = parts_obstacle(view.scene); !obstacle.empty()) return obstacle;
  if (wish.layers.error) return "pictures without layer error";
  if (wish.layers.bound) return "pictures without layer bound";
  return {};
}

/// Which pictures several processes can draw together; empty if this one is allowed.
std::string team_obstacle(const View& view, const Wish& wish) {
  const Layers& layers = wish.layers;
  if (layers.depth || layers.steps || layers.samples || layers.error || layers.bound)
    return "pictures without other layers than transmittance";
  if (view.scene.shows(Shows::plane)) return "pictures in other modes than slice";
  return region_obstacle(view, wish);
}

/// No atlas of the field is larger. `own_texels`: bricks of one value, and those between wide
/// tiles, may be stored one by one.
AtlasSize most_of(const Field& field, bool own_texels) {
  double bricks = 8 * double(field.leaves.size());
  for (const Tile& tile : field.tiles) {
    const double faces = 8 * 6 * std::pow(tile.width / 8 + 1, 2);
    bricks += own_texels || tile.width == 8 ? faces : 26;
  }
  AtlasSize size;
  size.texel_bytes = std::uint64_t(bricks) * brick_texels * sizeof(float) *
                     static_cast<std::uint64_t>(field.channels);
  return size;
}

/// Channels of the light's grid over the density's bricks; 0: no light is to be computed.
int light_channels(const View& view) {
  if (!view.medium.light) return 0;
  std::vector<Beam> beams = light_beams(view);
  if (!view.scene.environment.empty()) return 3;
  for (const Beam& beam : sky_beams(view, 1)) beams.push_back(beam);
  return luminance_channels(view.medium, beams);
}

/// What a view's grids take, on host or GPU [bytes].
struct Needs {
  Copies copies;                     ///< of texels that are split
  double density = 0;                ///< of its field, on the host
  double shine = 0;                  ///< of the light's field, on the host
  double fixed = 0;                  ///< however the view is split; twice, for values or a copy
  double texels = 0;                 ///< of the density and its gradient, which are split
  double light = 0;                  ///< of the light's texels, which are split, too
  double on_host = 0;                ///< values that a part reads from the file
  double bricks = 1;                 ///< of the density
  std::vector<glm::ivec3> places{};  ///< of these bricks
  int margin = 0;                    ///< bricks around a part that are stored, too
  double fields() const { return density + shine; }
  /// Of atlases on host and GPU, with all of them.
  double whole() const { return 2 * fixed + copies.whole * (texels + light); }
  /// A part of so many bricks, and `by` more around it, as a share of all bricks.
  double grown(double count, int by) const {
    return std::pow(std::cbrt(count) + 2 * by, 3) / bricks;
  }
  /// Of atlases on host and GPU, with some of the bricks.
  double of_part(double count) const {
    const double stored = std::min(grown(count, margin), 1.0);
    // a part's light and the values that it reads have another brick
    return 2 * fixed + copies.part * (texels * stored + light * grown(count, margin + 1)) +
           on_host * grown(count, margin + 1);
  }
};

/// What a view needs, or at most needs, which is found sooner. A density whose values stay in the
/// file is split by its topology.
Needs needs_of(const View& view, const Copies& copies, bool at_most = false) {
  const Medium& medium = view.medium;
  const Field& density = *medium.density;
  const AtlasOptions options = density_options(view);
  const int light = light_channels(view);
  Needs needs{.copies = copies};
  constexpr double stored_leaf = 32;  // origin, pointer and place
  needs.density = stored_leaf * double(density.leaves.size());
  const auto size_of = [&](const Field& field, const AtlasOptions& by = {},
                           std::vector<glm::ivec3>* places = nullptr) {
    return at_most ? most_of(field, by.own_texels) : predict_atlas(field, by, places);
  };
  AtlasSize size;
  if (density.reader) {
    needs.places = leaf_bricks(density);
    size.texel_bytes = needs.places.size() * brick_texels * sizeof(float);
    needs.on_host = double(value_bytes(density));
  } else {
    size = size_of(density, options, &needs.places);
    needs.density += double(value_bytes(density));
    constexpr double listed = 128;  // a block in lists of all that are visible, leaves, and to do
    if (light > 0)
      needs.shine = (512 * sizeof(float) * light + listed) *
                    (at_most ? most_visible_blocks(density)
                             : double(visible_blocks(density, options).size()));
  }
  needs.bricks = double(std::max<std::size_t>(needs.places.size(), 1));
  needs.texels = double(size.texel_bytes);
  needs.light = light * needs.texels;
  needs.fixed = double(1 + light) * double(size.page_bytes + size.constant_bytes);
  const glm::ivec3 ghost = region_ghost(view);
  needs.margin = std::max({ghost.x, ghost.y, ghost.z, int(options.with_margin)});
  if (medium.gradient) {
    const AtlasSize gradient = size_of(*medium.gradient);
    needs.texels += double(gradient.texel_bytes);
    needs.fixed += double(gradient.bytes() - gradient.texel_bytes);
  }
  const auto add = [&](const AtlasSize& other, int channels = 1) {
    needs.fixed += channels * double(other.bytes());
  };
  if (medium.luminance && !light) add(size_of(*medium.luminance));
  for (const Emission& emission : medium.emission) add(size_of(*emission.field));
  for (const Medium& other : medium.others) {
    add(size_of(*other.density, {.own_texels = light > 0}), 1 + light);
    for (const Emission& emission : other.emission) add(size_of(*emission.field));
  }
  return needs;
}

/// Error if a light's field does not fit beside the density's [bytes].
Error too_much_light(const View& view, const Needs& needs, double light, double all) {
  return {ExitCode::memory, "grid " + in_quotes(view.medium.density->name) + ": light needs " +
                                mebibytes(std::uint64_t(light)) + " beside the grid's " +
                                mebibytes(std::uint64_t(needs.density)) + ", over the limit of " +
                                mebibytes(std::uint64_t(all)) +
                                " for grids; raise --memory-limit or leave light out"};
}

/// Memory that is left for atlases beside fields, or a tenth of it all [bytes]: a limit is kept
/// within a tenth.
double left_beside(double fields, double limit) { return std::max(limit - fields, limit / 10); }

/// The most bricks of a region that keeps within the limit [bytes]. Throws Error(memory) if one
/// brick is too many, or the picture cannot be drawn in parts.
std::size_t most_bricks(const View& view, const Wish& wish, const Needs& needs, double limit) {
  const std::string obstacle = region_obstacle(view, wish);
  double count = needs.bricks;
  while (count >= 1 && needs.of_part(count) > limit) count *= 0.95;
  if (obstacle.empty() && count >= 1) return std::size_t(count);
  std::string why = "; --lod 1 takes an eighth of it";
  if (!obstacle.empty()) why += ", and only " + obstacle + " are drawn in parts";
  throw Error(ExitCode::memory, "grid '" + view.medium.density->name + "' needs an atlas of " +
                                    mebibytes(std::uint64_t(needs.whole())) +
                                    ", over the limit of " + mebibytes(std::uint64_t(limit)) + why);
}

/// The regions by which one process must draw a view; unset: its atlases fit.
std::optional<Regions> needed_regions(const View& view, const Wish& wish, const Copies& copies,
                                      std::optional<double> given_limit) {
  const bool in_file = view.medium.density->reader != nullptr;
  const bool must = given_limit || view.scene.memory_limit > 0 || in_file;
  const double all = given_limit ? *given_limit : double(grid_memory(view.scene));
  if (!in_file) {
    const Needs most = needs_of(view, copies, /*at_most=*/true);
    if (all == 0 || (given_limit ? 0 : most.fields()) + most.whole() <= all) return {};
  }
  Needs needs = needs_of(view, copies);
  if (!given_limit && must && needs.shine > 0 && needs.fields() > all)
    throw too_much_light(view, needs, needs.shine, all);
  const double limit = given_limit ? all : left_beside(needs.fields(), all);
  if (!in_file && needs.whole() <= limit) return {};
  if (!must && !region_obstacle(view, wish).empty()) return {};
  const std::size_t count = most_bricks(view, wish, needs, limit);
  return Regions(std::move(needs.places), count);
}

/// The regions by which a member draws its part. `sharing`: members on its machine.
Regions regions_of_part(const View& view, const Wish& wish, std::vector<glm::ivec3> bricks,
                        const Region& part, int sharing, const Copies& copies) {
  const Field& density = *view.medium.density;
  const bool limited = view.scene.memory_limit > 0;
  const double all = double(grid_memory(view.scene));
  std::size_t most = bricks.size();
  if (all > 0) {
    Needs needs = needs_of(view, copies);
    double limit = left_beside(needs.density, limited ? all : all / sharing);
    if (const int light = light_channels(view); light > 0) {
      // what stays in memory while a member lights its part: the light's values, and the density's
      const double share = std::pow(std::cbrt(double(part.count)) + 2 * needs.margin + 1, 3);
      const double held = std::min(share / needs.bricks, 1.0) * double(value_bytes(density)) *
                          (light + (density.reader ? 1 : 0));
      if (held >= limit)
        throw Error(
            ExitCode::memory,
            "grid " + in_quotes(density.name) + ": light needs " + mebibytes(std::uint64_t(held)) +
                " for the values of a process's part, and " + mebibytes(std::uint64_t(limit)) +
                " are left; start more processes, raise --memory-limit or leave light out");
      limit -= held;
      needs.on_host = 0;
    }
    most = most_bricks(view, wish, needs, limit);
  }
  std::erase_if(bricks, [&](const glm::ivec3& brick) { return !part.bricks.contains(brick); });
  return Regions(std::move(bricks), most, part.bricks);
}

}  // namespace

Copies copies_of(const Marcher& marcher, const View& view, bool replaces) {
  if (!marcher.draws_in_place() || view.scene.filter != Filter::exact) return {};
  // codes, and pairs of density and light, are made of texels
  const bool made = has_codes(view.scene.texel) || view.medium.light;
  return {.whole = replaces ? 1 : 2, .part = made ? 2 : 1};
}

std::string light_obstacle(const View& view) {
  try {
    const Needs needs = needs_of(view, {});
    const auto all = double(grid_memory(view.scene));
    if (needs.shine == 0 || all == 0) return {};
    const bool fits = needs.fields() <= all;
    const double least = fits ? std::min(needs.whole(), needs.of_part(1)) : 0;
    if (fits && least <= left_beside(needs.fields(), all)) return {};
    return too_much_light(view, needs, needs.shine + least, all).what();
  } catch (const Error& error) {
    if (error.code() != ExitCode::memory) throw;
    return error.what();
  }
}

Split split_of(const View& view, const Wish& wish, const Copies& copies,
               std::optional<double> limit) {
  Split split;
  if (wish.team->size() == 1) {
    if (auto regions = needed_regions(view, wish, copies, limit))
      split = {false, Regions({}, 1), std::move(*regions)};
    return split;
  }
  if (const std::string obstacle = team_obstacle(view, wish); !obstacle.empty())
    throw Error(ExitCode::usage, "several processes draw only " + obstacle + " together");
  const std::vector<glm::ivec3> bricks = leaf_bricks(*view.medium.density);
  split.whole = false;
  split.parts = Regions::in_parts(bricks, std::size_t(wish.team->size()));
  const Region part = split.parts.all()[std::size_t(wish.team->rank())];
  split.own = regions_of_part(view, wish, bricks, part, wish.team->place().local_size, copies);
  const glm::ivec3 ghost = region_ghost(view);
  split.lit = {part.bricks.min - ghost, part.bricks.max + ghost};
  return split;
}

}  // namespace psivox
