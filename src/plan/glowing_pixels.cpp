#include "plan/pilot.h"

#include <algorithm>
#include <array>

#include "atlas/atlas.h"
#include "field/index_space.h"
#include "march/pixel_box.h"

namespace psivox {
namespace {

/// Parts along each side of the picture.
constexpr int parts = 8;

/// The middle of the pixels that may show a voxel of the view's density.
glm::ivec2 pixel_of(const View& view, const glm::ivec3& voxel) {
  const PixelBox box = pixels_of(view, glm::dvec3(voxel) - 0.5, glm::dvec3(voxel) + 0.5);
  return box.empty() ? glm::ivec2(-1) : box.origin + box.size / 2;
}

/// Adds 8 x 8 pixels of those that may show a field, or all of fewer.
void add_spread(View& view, const std::shared_ptr<const Field>& field,
                std::vector<glm::ivec2>& pixels) {
  view.medium.density = field;
  const Box domain = field->domain();
  const PixelBox box = pixels_of(view, glm::dvec3(domain.min), glm::dvec3(domain.max));
  const glm::ivec2 count = glm::min(box.size, glm::ivec2(8));
  for (int y = 0; y < count.y; ++y)
    for (int x = 0; x < count.x; ++x)
      pixels.push_back(box.origin + (2 * glm::ivec2(x, y) + 1) * box.size / (2 * count));
}

struct Glow {
  float value = 0;
  glm::ivec2 pixel{0};
};

}  // namespace

std::vector<glm::ivec2> glowing_pixels(const View& view, const MediumAtlas& atlas) {
  std::array<Glow, parts * parts> brightest;
  View from = view;
  const glm::ivec2& size = view.scene.resolution;
  for (std::size_t i = 0; i < view.medium.emission.size(); ++i) {
    const BrickAtlas& emission = atlas.emission[i];
    from.medium.density = view.medium.emission[i].field;
    const double scale = view.medium.emission[i].scale * finest_voxel(*from.medium.density);
    const auto channels = std::size_t(emission.channels);
    for_entries(emission.pages, [&](std::uint32_t entry, const glm::ivec3& brick, int width) {
      const bool textured = entry_kind(entry) == EntryKind::brick;
      const float* first =
          textured ? &emission.texels[emission.pages.slot(entry) * brick_texels * channels]
                   : &emission.constants[entry_payload(entry) * channels];
      const float* most = std::max_element(first, first + (textured ? brick_texels : 1) * channels);
      const int texel = int(std::size_t(most - first) / channels);
      constexpr int n = brick_values;
      // the middle of a run of one value
      const glm::ivec3 inside = textured ? glm::ivec3(texel / (n * n), texel / n % n, texel % n)
                                         : glm::ivec3(brick_cells * width / 2);
      const glm::ivec2 pixel = pixel_of(from, emission.pages.min + brick_cells * brick + inside);
      if (glm::clamp(pixel, glm::ivec2(0), size - 1) != pixel) return;
      const glm::ivec2 part = pixel * parts / size;
      Glow& glow = brightest[std::size_t(part.y * parts + part.x)];
      if (const float value = float(scale) * *most; value > glow.value) glow = {value, pixel};
    });
  }
  std::vector<glm::ivec2> pixels;
  for (const Glow& glow : brightest)
    if (glow.value > 0) pixels.push_back(glow.pixel);
  for (const Medium& other : view.medium.others) {
    add_spread(from, other.density, pixels);
    for (const Emission& own : other.emission) add_spread(from, own.field, pixels);
  }
  return pixels;
}

}  // namespace psivox
