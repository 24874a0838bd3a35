#include "march/medium_atlas.h"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <optional>
#include <utility>

#include "field/index_space.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "march/grids.h"
#include "march/march_parameters.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

AtlasSize& operator+=(AtlasSize& sum, const AtlasSize& size) {
  sum.textured_bricks += size.textured_bricks;
  sum.constant_bricks += size.constant_bricks;
  sum.page_bytes += size.page_bytes;
  sum.constant_bytes += size.constant_bytes;
  sum.texel_bytes += size.texel_bytes;
  return sum;
}

/// Voxels of `to` that hold all points of a box of voxels of `from`.
Box mapped(const Box& box, const glm::dmat4& to_from) {
  const auto [low, high] = bounds_of(box, to_from);
  // a voxel's rounding to either side where the two lattices are the same
  constexpr double rounding = 1e-6;
  return {glm::ivec3(glm::floor(low + rounding)), glm::ivec3(glm::ceil(high - rounding))};
}

/// Boxes of `density`'s voxels where `other` has values, each grown by the voxel that its tent
/// reaches.
std::vector<Box> where_values_are(const Field& other, const Field& density) {
  const glm::dmat4 to_density = glm::inverse(density.world_from_index) * other.world_from_index;
  std::vector<Box> boxes;
  const auto add = [&](const glm::ivec3& origin, int width) {
    const Box domain = other.domain();
    boxes.push_back(mapped({glm::max(origin - 1, domain.min), glm::min(origin + width, domain.max)},
                           to_density));
  };
  for (const Leaf& leaf : other.leaves)
    if (std::ranges::any_of(OrderedValues(other, leaf), [](float v) { return v != 0; }))
      add(leaf.origin, 8);
  for (const Tile& tile : other.tiles) add(tile.origin, tile.width);
  return boxes;
}

/// The value up to which a function attenuates nothing and behind which it always does, if there is
/// one.
std::optional<double> threshold(const TransferFunction& function) {
  const std::vector<TransferPoint>& points = function.points();
  const auto clear = [](const TransferPoint& point) { return point.attenuation == 0; };
  const auto first = std::find_if_not(points.begin(), points.end(), clear);
  if (first == points.begin() || first == points.end()) return {};
  if (std::any_of(first, points.end(), clear)) return {};
  return (first - 1)->value;
}

void add_others(const Medium& medium, MediumAtlas& atlas) {
  std::vector<OtherBricks> parts;
  for (std::size_t i = 0; i < medium.others.size(); ++i) {
    const Medium& other = medium.others[i];
    OtherBricks& part = parts.emplace_back(
        OtherBricks{.volume = i, .bricks = build_atlas(*other.density, {.own_texels = other.lit})});
    if (other.lit) part.light = build_beside(*other.luminance, part.bricks);
    for (std::size_t k = 0; k < other.emission.size(); ++k)
      parts.push_back({.volume = i, .emits = k, .bricks = build_atlas(*other.emission[k].field)});
  }
  join_others(parts, atlas);
}

/// Adds the view's luminance, light beside the density.
void add_own_luminance(MediumAtlas& atlas, const Medium& medium, std::optional<Field> apart) {
  const Field& luminance = apart ? *apart : *medium.luminance;
  Storage* const goes = apart ? &apart->storage : nullptr;
  atlas.paired = medium.lit && atlas.density.own_texels;
  atlas.luminance = atlas.paired ? build_beside(luminance, atlas.density, goes)
                                 : build_atlas(luminance, {}, goes);
}

}  // namespace

AtlasSize MediumAtlas::size() const {
  AtlasSize sum;
  for (const BrickAtlas* grid : grids_of(*this))
    if (grid) sum += grid->size;
  return sum;
}

bool needs_every_value(const Scene& scene) {
  return is_transfer_rule(scene.resolved_integrator()) &&
         scene.resolved_sampling() != Sampling::cells;
}

AtlasOptions density_options(const View& view) {
  AtlasOptions options;
  const Medium& medium = view.medium;
  if (view.scene.attenuates() && medium.extinction == 0) {
    options.visible = [](const ValueRange&, const ValueRange&) { return false; };
  } else if (view.scene.shows(Shows::surface)) {
    options.visible = [surfaces = medium.surfaces](const ValueRange& own, const ValueRange&) {
      return std::ranges::any_of(surfaces, [&](const Surface& surface) {
        const auto isovalue = float(surface.isovalue);
        return own.min <= isovalue && isovalue <= own.max;
      });
    };
    options.with_margin = true;  // normals are central differences
  } else if (medium.transfer && !view.scene.shows(Shows::value) &&
             !view.scene.shows(Shows::plane)) {
    const bool every_value = needs_every_value(view.scene);
    options.companion = medium.gradient;
    const std::optional<double> begins =
        medium.gradient ? std::nullopt : threshold(*medium.transfer);
    options.visible = [transfer = medium.transfer, every_value, begins](
                          const ValueRange& own, const ValueRange& gradients) {
      if (begins && !every_value) return double(own.max) > *begins;
      return (every_value && (own.min != 0 || own.max != 0)) ||
             transfer->max_attenuation(glm::dvec2(own.min, own.max),
                                       glm::dvec2(gradients.min, gradients.max)) > 0;
    };
  }
  options.keeps_absent = view.scene.shows(Shows::value) || view.scene.shows(Shows::plane);
  options.own_texels = medium.light || medium.lit;  // its light is stored beside it
  options.mark_octants = true;
  const auto walk = [&](const Field& other) {
    for (Box box : where_values_are(other, *medium.density)) {
      if (medium.nearest) box.max += 1;  // rays run half a voxel beside the density
      options.walked.push_back(box);
    }
  };
  for (const Emission& emission : medium.emission) walk(*emission.field);
  for (const Medium& other : medium.others) {
    walk(*other.density);
    for (const Emission& emission : other.emission) walk(*emission.field);
  }
  return options;
}

MediumAtlas build_medium_atlas(const View& view, std::optional<Field> density) {
  const Medium& medium = view.medium;
  MediumAtlas result;
  result.density = build_atlas(density ? *density : *medium.density, density_options(view),
                               density ? &density->storage : nullptr);
  density.reset();
  if (medium.luminance && !medium.light) add_own_luminance(result, medium, {});
  for (const Emission& emission : medium.emission)
    result.emission.push_back(build_atlas(*emission.field));
  if (medium.gradient) result.gradient = build_atlas(*medium.gradient);
  add_others(medium, result);
  return result;
}

constexpr std::uint64_t region_top_entries = std::uint64_t{1} << 15;

glm::ivec3 region_ghost(const View& view) {
  if (view.scene.resolved_sampling() == Sampling::cells) return {};
  const Field& density = *view.medium.density;
  const double step = view.scene.resolved_step() * finest_voxel(density);
  // the most voxels along each axis in that length of the world
  const glm::dmat3 rows = glm::transpose(glm::inverse(glm::dmat3(density.world_from_index)));
  glm::ivec3 ghost;
  for (int axis = 0; axis < 3; ++axis)
    ghost[axis] = 1 + int(std::min(step * glm::length(rows[axis]) / 8, double(far_away / 8)));
  return ghost;
}

Field field_of_bricks(const Field& field, const Box& bricks, bool with_margin) {
  const Box voxels = voxels_of(bricks);
  return part_of_field(field, {voxels.min - (with_margin ? 8 : 0), voxels.max + 8});
}

MediumAtlas build_region_atlas(const View& view, const Box& region, const glm::ivec3& ghost) {
  const Medium& medium = view.medium;
  const Box stored{region.min - ghost, region.max + ghost};
  const auto build = [&](const Field& field, AtlasOptions options, std::optional<Box> part) {
    options.region = part.value_or(everywhere);
    // a region is a small part of the domain: a dense table of it would be the largest of all
    options.top_entries = region_top_entries;
    if (!part) return build_atlas(field, options);
    return build_atlas(field_of_bricks(field, *part, options.with_margin), options);
  };
  MediumAtlas result{build(*medium.density, density_options(view), stored), {}, {}, {}, {}};
  result.part = region;
  result.greatest = stored_range(*medium.density).y;
  result.paired = medium.lit && result.density.own_texels;
  if (result.paired) {
    result.luminance =
        build_beside(field_of_bricks(*medium.luminance, stored, false), result.density);
  } else if (medium.luminance) {
    // a value on a region's face may be looked up in the brick beyond it
    std::optional<Box> grown;
    if (medium.luminance->world_from_index == medium.density->world_from_index)
      grown = Box{stored.min - 1, stored.max + 1};
    result.luminance = build(*medium.luminance, {}, grown);
  }
  for (const Emission& emission : medium.emission)
    result.emission.push_back(build(*emission.field, {}, {}));
  if (medium.gradient) result.gradient = build(*medium.gradient, {}, stored);
  return result;
}

MediumAtlas coded(MediumAtlas atlas, const std::vector<CodeWidth>& widths, bool replaces) {
  atlas.density =
      coded(atlas.density, widths, atlas.paired ? &*atlas.luminance : nullptr, replaces);
  if (atlas.paired) {
    atlas.luminance->texels.reset();
    atlas.luminance->size.texel_bytes = 0;
  }
  return atlas;
}

CodeWidths fixed_widths(const MediumAtlas& atlas, TexelType texel) {
  if (!has_codes(texel)) return {};
  const auto width = CodeWidth(int(texel) - int(TexelType::code7));
  return std::make_shared<std::vector<CodeWidth>>(atlas.density.bricks.size(), width);
}

void add_luminance(MediumAtlas& atlas, const View& view, std::optional<Field> luminance) {
  atlas.luminance.reset();
  add_own_luminance(atlas, view.medium, std::move(luminance));
  add_others(view.medium, atlas);
}

}  // namespace psivox
