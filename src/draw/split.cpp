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

/// More than the field's bricks can take on host and GPU [bytes]. `own_texels`: bricks of one
/// value, and those between wide tiles, may be stored one by one.
double most_bytes(const Field& field, bool own_texels) {
  double bricks = 8 * double(field.leaves.size());
  for (const Tile& tile : field.tiles) {
    const double faces = 8 * 6 * std::pow(tile.width / 8 + 1, 2);
    bricks += own_texels || tile.width == 8 ? faces : 26;
  }
  return 2 * bricks * brick_texels * sizeof(float) * field.channels;
}

/// What a view's grids take, on host or GPU [bytes].
struct Needs {
  Copies copies;                     ///< of texels that are split
  double fixed = 0;                  ///< however the view is split; twice, for values or a copy
  double texels = 0;                 ///< of the density and its gradient, which are split
  double light = 0;                  ///< of the light's texels, which are split, too
  double on_host = 0;                ///< values that a part reads from the file
  double bricks = 1;                 ///< of the density
  std::vector<glm::ivec3> places{};  ///< of these bricks
  int margin = 0;                    ///< bricks around a part that are stored, too
  /// On host and GPU, with all of them.
  double whole() const { return 2 * fixed + copies.whole * (texels + light); }
  /// On host and GPU, with some of the bricks.
  double of_part(double count) const {
    const auto grown = [&](int by) { return std::pow(std::cbrt(count) + 2 * by, 3) / bricks; };
    const double stored = std::min(grown(margin), 1.0);
    // a part's light and the values that it reads have another brick
    return 2 * fixed + copies.part * (texels * stored + light * grown(margin + 1)) +
           on_host * grown(margin + 1);
  }
};

/// What a view needs. A density whose values stay in the file is split by its topology.
Needs needs_of(const View& view, int light, const Copies& copies) {
  const Medium& medium = view.medium;
  Needs needs{.copies = copies};
  const glm::ivec3 ghost = region_ghost(view);
  needs.margin = std::max({ghost.x, ghost.y, ghost.z, int(density_options(view).with_margin)});
  if (medium.density->reader) {
    needs.places = leaf_bricks(*medium.density);
    needs.bricks = double(std::max<std::size_t>(needs.places.size(), 1));
    needs.texels = needs.bricks * brick_texels * sizeof(float);
    needs.light = light * needs.texels;
    needs.on_host = double(value_bytes(*medium.density));
  } else {
    const AtlasSize density = predict_atlas(*medium.density, density_options(view), &needs.places);
    needs.bricks = double(std::max<std::uint64_t>(density.textured_bricks, 1));
    needs.texels = double(density.texel_bytes);
    needs.light = light * double(density.texel_bytes);
    needs.fixed = double((1 + light) * (density.page_bytes + density.constant_bytes));
  }
  if (medium.gradient) {
    const AtlasSize gradient = predict_atlas(*medium.gradient);
    needs.texels += double(gradient.texel_bytes);
    needs.fixed += double(gradient.bytes() - gradient.texel_bytes);
  }
  const auto add = [&](const Field& field, int channels) {
    needs.fixed += channels * double(predict_atlas(field).bytes());
  };
  if (medium.luminance && !light) add(*medium.luminance, 1);
  for (const Emission& emission : medium.emission) add(*emission.field, 1);
  for (const Medium& other : medium.others) {
    add(*other.density, 1 + light);
    for (const Emission& emission : other.emission) add(*emission.field, 1);
  }
  return needs;
}

/// What the density's field takes on the host [bytes].
double density_bytes(const View& view) {
  const Field& density = *view.medium.density;
  constexpr double stored_leaf = 32;  // origin, pointer and place
  const double leaves = stored_leaf * double(density.leaves.size());
  return leaves + (density.reader ? 0 : double(value_bytes(density)));
}

/// What the light's field takes on the host, with the places of its blocks in lists of all that are
/// visible, of leaves and of those still to be computed [bytes].
double light_bytes(const View& view, int light) {
  if (light == 0 || view.medium.density->reader) return 0;
  constexpr double places = 128;
  const auto blocks = double(visible_blocks(*view.medium.density, density_options(view)).size());
  return blocks * (512 * sizeof(float) * light + places);
}

/// Error if a light's field does not fit beside the density's [bytes].
Error too_much_light(const View& view, double shine, double all) {
  return {ExitCode::memory, "grid " + in_quotes(view.medium.density->name) + ": light needs " +
                                mebibytes(std::uint64_t(shine)) + " beside the grid's " +
                                mebibytes(std::uint64_t(density_bytes(view))) +
                                ", over the limit of " + mebibytes(std::uint64_t(all)) +
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

/// Channels of the light's grid over the density's bricks; 0: no light is to be computed.
int light_channels(const View& view) {
  if (!view.medium.light) return 0;
  std::vector<Beam> beams = light_beams(view);
  if (!view.scene.environment.empty()) return 3;
  for (const Beam& beam : sky_beams(view, 1)) beams.push_back(beam);
  return luminance_channels(view.medium, beams);
}

/// What stays in memory while a member lights and draws its part [bytes]: the density's values, if
/// they do not stay in the file, and the light's.
double held_bytes(const View& view, const Needs& needs, const Region& part, int light) {
  const Field& density = *view.medium.density;
  const double grown = std::pow(std::cbrt(double(part.count)) + 2 * needs.margin + 1, 3);
  const double share = std::min(grown / needs.bricks, 1.0);
  return share * double(value_bytes(density)) * (light + (density.reader ? 1 : 0));
}

/// The regions by which one process must draw a view; unset: its atlases fit.
std::optional<Regions> needed_regions(const View& view, const Wish& wish, const Copies& copies,
                                      std::optional<double> given_limit) {
  const Medium& medium = view.medium;
  const bool in_file = medium.density->reader != nullptr;
  const bool must = given_limit || view.scene.memory_limit > 0 || in_file;
  const double all = given_limit ? *given_limit : double(grid_memory(view.scene));
  const int light = light_channels(view);
  // a block of light beside each of a leaf's blocks
  double most = (1 + light) * most_bytes(*medium.density, density_options(view).own_texels) +
                27 * light * double(value_bytes(*medium.density));
  for (const Field* field : fields_of(medium))
    if (field && field != medium.density.get()) most += most_bytes(*field, false);
  for (const Medium& other : medium.others) {
    most += (1 + light) * most_bytes(*other.density, light > 0);
    for (const Emission& emission : other.emission) most += most_bytes(*emission.field, false);
  }
  double limit = given_limit ? all : left_beside(density_bytes(view), all);
  if (!in_file && (limit == 0 || most <= limit)) return {};

  if (!given_limit) {
    const double shine = light_bytes(view, light), fields = density_bytes(view) + shine;
    if (must && shine > 0 && fields > all) throw too_much_light(view, shine, all);
    limit = left_beside(fields, all);
  }
  Needs needs = needs_of(view, light, copies);
  if (!in_file && needs.whole() <= limit) return {};
  if (!must && !region_obstacle(view, wish).empty()) return {};
  const std::size_t count = most_bricks(view, wish, needs, limit);
  return Regions(std::move(needs.places), count);
}

/// The regions by which a member draws its part. `sharing`: members on its machine.
Regions regions_of_part(const View& view, const Wish& wish, std::vector<glm::ivec3> bricks,
                        const Region& part, int sharing, const Copies& copies) {
  const bool limited = view.scene.memory_limit > 0;
  const double all = double(grid_memory(view.scene));
  std::size_t most = bricks.size();
  if (all > 0) {
    double limit = left_beside(density_bytes(view), limited ? all : all / sharing);
    const int light = light_channels(view);
    Needs needs = needs_of(view, light, copies);
    if (light > 0) {
      const double held = held_bytes(view, needs, part, light);
      if (held >= limit)
        throw Error(ExitCode::memory,
                    "grid " + in_quotes(view.medium.density->name) + ": light needs " +
                        mebibytes(std::uint64_t(held)) +
                        " for the values of a process's part, and " +
                        mebibytes(std::uint64_t(limit)) +
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
    const int light = light_channels(view);
    const double shine = light_bytes(view, light), fields = density_bytes(view) + shine;
    const auto all = double(grid_memory(view.scene));
    if (shine == 0 || all == 0) return {};
    if (fields > all) return too_much_light(view, shine, all).what();
    const double limit = left_beside(fields, all);
    const Needs needs = needs_of(view, light, {});
    const double least = std::min(needs.whole(), needs.of_part(1));
    return least <= limit ? "" : too_much_light(view, shine + least, all).what();
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
  return split;
}

}  // namespace psivox
