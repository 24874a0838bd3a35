#include "plan/light_through.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <optional>

#include "atlas/page_walk.h"
#include "field/index_space.h"
#include "march/pixel_box.h"
#include "plan/brick_effects.h"

namespace psivox {
namespace {

/// Parts of the picture along its longer side, by which light is bounded.
constexpr int most_parts = 128;
/// Parts along each side in which the brightest emission is looked for.
constexpr int glow_parts = 8;

/// Pixels of a view whose rays may meet a box of a field's voxels.
class Footprints {
 public:
  explicit Footprints(const View& view) : view_(view) {}
  void set_field(const std::shared_ptr<const Field>& field) { view_.medium.density = field; }
  const glm::ivec2& size() const { return view_.scene.resolution; }
  PixelBox of(const Box& box) const {
    return pixels_of(view_, glm::dvec3(box.min), glm::dvec3(box.max));
  }
  glm::ivec2 pixel(const glm::ivec3& voxel) const {
    const PixelBox box = pixels_of(view_, glm::dvec3(voxel) - 0.5, glm::dvec3(voxel) + 0.5);
    return box.empty() ? glm::ivec2(-1) : box.origin + box.size / 2;
  }

 private:
  View view_;  ///< its density is the field
};

int glow_part(const glm::ivec2& pixel, const glm::ivec2& size) {
  const glm::ivec2 at = pixel * glow_parts / size;
  return at.y * glow_parts + at.x;
}

/// Bounds of the radiance of the rays in parts of a picture.
class LightBounds {
 public:
  LightBounds(const View& view, const Backdrop& behind) : at_(in_parts(view)) {
    const Backdrop parts = behind.greatest_in_parts(at_.size());
    const glm::ivec2& size = at_.size();
    bounds_.resize(std::size_t(size.x) * std::size_t(size.y));
    for (std::size_t i = 0; i < bounds_.size(); ++i) bounds_[i] = greatest_of(parts.at(i));
  }

  void set_field(const std::shared_ptr<const Field>& field) { at_.set_field(field); }
  void include(const Box& box, double radiance) {
    if (radiance <= 1) return;
    each(at_.of(box), [&](std::size_t i) { bounds_[i] = std::max(bounds_[i], radiance); });
  }
  /// Of all rays in a pixel's part of the picture.
  void include(const SeenPixel& seen, const glm::ivec2& picture) {
    const int part = glow_part(seen.pixel, picture);
    const glm::ivec2 first(part % glow_parts, part / glow_parts), size = at_.size();
    const glm::ivec2 from = first * size / glow_parts;
    const glm::ivec2 to = ((first + 1) * size + glow_parts - 1) / glow_parts;
    each({from, to - from},
         [&](std::size_t i) { bounds_[i] = std::max(bounds_[i], seen.radiance()); });
  }
  double greatest(const Box& box) const {
    double most = 1;
    each(at_.of(box), [&](std::size_t i) { most = std::max(most, bounds_[i]); });
    return most;
  }

 private:
  static View in_parts(View view) {
    glm::ivec2& size = view.scene.resolution;
    const double scale = std::min(1.0, most_parts / double(std::max(size.x, size.y)));
    size = glm::max(glm::ivec2(1), glm::ivec2(glm::dvec2(size) * scale));
    return view;
  }
  void each(const PixelBox& parts, const auto& visit) const {
    for (int y = parts.origin.y; y < parts.origin.y + parts.size.y; ++y)
      for (int x = parts.origin.x; x < parts.origin.x + parts.size.x; ++x)
        visit(std::size_t(y) * std::size_t(at_.size().x) + std::size_t(x));
  }

  Footprints at_;
  std::vector<double> bounds_;
};

/// Calls visit(box, slot, constant) for the bricks of an atlas and its runs of one value: either
/// there is a slot, or a constant.
void for_boxes(const BrickAtlas& atlas, const auto& visit) {
  for_entries(atlas.pages, [&](std::uint32_t entry, const glm::ivec3& first, int width) {
    const glm::ivec3 least = atlas.pages.min + brick_cells * first;
    const Box box{least, least + brick_cells * width};
    if (entry_kind(entry) == EntryKind::brick)
      visit(box, std::optional(std::size_t(atlas.pages.slot(entry))), nullptr);
    else
      visit(box, std::optional<std::size_t>(),
            &atlas.constants[entry_payload(entry) * std::size_t(atlas.channels)]);
  });
}

struct Glow {
  double value = 0;
  glm::ivec3 voxel{0};
};

/// The voxel of a box that emits most in any channel.
Glow brightest_voxel(const BrickAtlas& atlas, const Box& box, std::optional<std::size_t> slot,
                     const float* constant) {
  const auto channels = std::size_t(atlas.channels);
  if (!slot)
    return {double(*std::max_element(constant, constant + channels)), (box.min + box.max) / 2};
  const float* first = atlas.texels.get() + *slot * brick_texels * channels;
  const float* most = std::max_element(first, first + brick_texels * channels);
  const int texel = int(std::size_t(most - first) / channels);
  constexpr int n = brick_values;
  return {double(*most), box.min + glm::ivec3(texel / (n * n), texel / n % n, texel % n)};
}

/// Adds 8 x 8 pixels of a rectangle, or all of a smaller one.
void add_spread(const PixelBox& box, std::vector<glm::ivec2>& pixels) {
  const glm::ivec2 count = glm::min(box.size, glm::ivec2(8));
  for (int y = 0; y < count.y; ++y)
    for (int x = 0; x < count.x; ++x)
      pixels.push_back(box.origin + (2 * glm::ivec2(x, y) + 1) * box.size / (2 * count));
}

/// Of 0, too.
ValueRange range_of(const BrickAtlas& atlas) {
  ValueRange range;
  const auto include = [&](float min, float max) {
    range.min = std::min(range.min, min);
    range.max = std::max(range.max, max);
  };
  for (const BrickStats& brick : atlas.bricks) include(brick.min, brick.max);
  for (const float constant : atlas.constants) include(constant, constant);
  return range;
}

/// The bounds of a further volume are those of its box.
void include_volume(const Medium& volume, LightBounds& light) {
  double emission = 0;
  for (const Emission& own : volume.emission) emission += own.brightest;
  light.set_field(volume.density);
  light.include(volume.density->domain(), volume.brightest + emission);
  for (const Emission& own : volume.emission) {
    light.set_field(own.field);
    light.include(own.field->domain(), volume.brightest + emission);
  }
}

}  // namespace

std::vector<glm::ivec2> glowing_pixels(const View& view, const MediumAtlas& atlas) {
  struct Target {
    double radiance = 0;
    glm::ivec2 pixel{0};
  };
  std::vector<Target> targets(glow_parts * glow_parts);
  Footprints at(view);
  for (std::size_t i = 0; i < view.medium.emission.size(); ++i) {
    const Emission& emission = view.medium.emission[i];
    const double scale = emission.scale * finest_voxel(*emission.field);
    at.set_field(emission.field);
    for_boxes(atlas.emission[i],
              [&](const Box& box, std::optional<std::size_t> slot, const float* constant) {
                const Glow glow = brightest_voxel(atlas.emission[i], box, slot, constant);
                const glm::ivec2 pixel = at.pixel(glow.voxel);
                if (glm::any(glm::lessThan(pixel, glm::ivec2(0))) ||
                    glm::any(glm::greaterThanEqual(pixel, at.size())))
                  return;
                Target& target = targets[std::size_t(glow_part(pixel, at.size()))];
                if (scale * glow.value > target.radiance) target = {scale * glow.value, pixel};
              });
  }
  std::vector<glm::ivec2> pixels;
  for (const Target& target : targets)
    if (target.radiance > 0) pixels.push_back(target.pixel);
  for (const Medium& other : view.medium.others) {
    at.set_field(other.density);
    add_spread(at.of(other.density->domain()), pixels);
    for (const Emission& own : other.emission) {
      at.set_field(own.field);
      add_spread(at.of(own.field->domain()), pixels);
    }
  }
  return pixels;
}

std::vector<double> light_through(const View& view, const MediumAtlas& atlas,
                                  const Backdrop& behind, std::span<const SeenPixel> seen) {
  const BrickAtlas& density = atlas.density;
  const Peak peak(view, atlas);
  if (seen.empty() && view.medium.others.empty() && behind.pixels().empty()) {
    const double common = std::max(1.0, behind.greatest());
    const ValueRange all = range_of(density);
    const double highest = peak.at(all.min, all.max);
    if (highest <= common || !peak.depends_on_value())
      return std::vector<double>(density.bricks.size(), std::max(common, highest));
  }
  LightBounds light(view, behind);
  for_boxes(density, [&](const Box& box, std::optional<std::size_t> slot, const float* constant) {
    const double min = slot ? density.bricks[*slot].min : *constant;
    const double max = slot ? density.bricks[*slot].max : *constant;
    light.include(box, peak.at(min, max));
  });
  for (const SeenPixel& pixel : seen) light.include(pixel, view.scene.resolution);
  for (const Medium& other : view.medium.others) include_volume(other, light);
  light.set_field(view.medium.density);
  std::vector<double> through(density.bricks.size(), 1.0);
  for_boxes(density, [&](const Box& box, std::optional<std::size_t> slot, const float*) {
    if (slot) through[*slot] = std::max(through[*slot], light.greatest(box));
  });
  return through;
}

}  // namespace psivox
