#include "view/picture_display.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "psivox/picture_file.h"

namespace psivox::view {
namespace {

glm::ivec2 size_of(const Image& image) { return {image.width, image.height}; }

/// Copies a rectangle; places are pixels from the top left.
void copy(const Image& from, const glm::ivec2& at, Image& to, const glm::ivec2& to_at,
          const glm::ivec2& size) {
  for (int y = 0; y < size.y; ++y)
    std::copy_n(&from.rgba()[4 * from.index(at.x, at.y + y)], 4 * size.x,
                &to.rgba()[4 * to.index(to_at.x, to_at.y + y)]);
}

void blit(GLuint from, const glm::ivec2& size, GLuint to, const glm::ivec2& to_size, bool flipped) {
  glBlitNamedFramebuffer(from, to, 0, 0, size.x, size.y, 0, flipped ? to_size.y : 0, to_size.x,
                         flipped ? 0 : to_size.y, GL_COLOR_BUFFER_BIT,
                         size == to_size ? GL_NEAREST : GL_LINEAR);
}

}  // namespace

PictureDisplay::PictureDisplay() {
  for (Side& side : sides_) side.preview = rgba_image(1, 1);
}

PictureDisplay::Screen::~Screen() {
  glDeleteFramebuffers(1, &framebuffer);
  glDeleteTextures(1, &texture);
}

void PictureDisplay::Screen::fit(const glm::ivec2& wanted) {
  if (texture && size == wanted) return;
  glDeleteTextures(1, &texture);
  if (!framebuffer) glCreateFramebuffers(1, &framebuffer);
  glCreateTextures(GL_TEXTURE_2D, 1, &texture);
  glTextureStorage2D(texture, 1, GL_RGBA8, wanted.x, wanted.y);
  glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, texture, 0);
  size = wanted;
}

void PictureDisplay::Screen::put(const PixelBox& part, std::span<const std::uint8_t> rgb) {
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(texture, 0, part.origin.x, part.origin.y, part.size.x, part.size.y, GL_RGB,
                      GL_UNSIGNED_BYTE, rgb.data());
}

void PictureDisplay::set_preview(PicturePart picture) {
  Side& side = sides_[picture.side];
  side.preview = std::move(picture.image);
  if (side.number != picture.number) side.number = 0;
  stale_ = true;
}

void PictureDisplay::add_part(const PicturePart& part) {
  Side& side = sides_[part.side];
  if (side.number != part.number) {
    side.exact = rgba_image(part.picture_size.x, part.picture_size.y);
    side.number = part.number;
    side.parts.clear();
    side.encoded = 0;
  }
  copy(part.image, {0, 0}, side.exact, part.origin, size_of(part.image));
  side.parts.push_back({part.origin, size_of(part.image)});
}

std::optional<Image> PictureDisplay::exact(std::uint64_t number, std::size_t side) const {
  if (number == 0 || sides_[side].number != number) return {};
  return sides_[side].exact;
}

std::vector<std::uint8_t> PictureDisplay::codes(std::size_t to, Image Side::*picture,
                                                const PixelBox& part) const {
  const auto piece_of = [&](const Side& side) {
    Image piece = rgba_image(part.size.x, part.size.y);
    copy(side.*picture, part.origin, piece, {0, 0}, part.size);
    return piece;
  };
  Image piece = piece_of(sides_[to]);
  const bool comparable = size_of(sides_[0].*picture) == size_of(sides_[1].*picture);
  if (settings_.comparison == Comparison::difference && comparable)
    return srgb_bytes(difference_picture(piece, piece_of(sides_[1]), 1 / settings_.gain), {});
  add_background(piece, settings_.background, {});
  return srgb_bytes(piece, settings_.display);
}

const PictureDisplay::Screen& PictureDisplay::encode(std::size_t to, const glm::ivec2& size) {
  Side& side = sides_[to];
  // the parts of a difference are there once the right picture has them: it comes after the left
  const Side& last = settings_.comparison == Comparison::difference ? sides_[1] : side;
  if (stale_) {
    side.encoded = 0;
    const PixelBox all{{0, 0}, size_of(side.preview)};
    side.small.fit(all.size);
    side.small.put(all, codes(to, &Side::preview, all));
  }
  if (!side.number || !last.number || size_of(side.exact) != size || size_of(last.exact) != size)
    return side.small;
  if (side.encoded == 0) {
    side.refined.fit(size);
    blit(side.small.framebuffer, side.small.size, side.refined.framebuffer, size, false);
  }
  for (; side.encoded < last.parts.size(); ++side.encoded) {
    const PixelBox& part = last.parts[side.encoded];
    side.refined.put(part, codes(to, &Side::exact, part));
  }
  return side.refined;
}

void PictureDisplay::draw(const glm::ivec2& size, const DisplaySettings& settings) {
  settings_.divider = settings.divider;
  if (!(settings == settings_)) stale_ = true;
  settings_ = settings;
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, size.x, size.y);
  const bool wipe = settings.comparison == Comparison::wipe;
  const int divider = wipe ? int(std::lround(settings.divider * size.x)) : size.x;
  for (std::size_t i = 0; i < (wipe ? 2u : 1u); ++i) {
    const Screen& from = encode(i, size);
    glEnable(GL_SCISSOR_TEST);
    glScissor(i ? divider : 0, 0, i ? size.x - divider : divider, size.y);
    blit(from.framebuffer, from.size, 0, size, true);
    glDisable(GL_SCISSOR_TEST);
  }
  stale_ = false;
}

}  // namespace psivox::view
