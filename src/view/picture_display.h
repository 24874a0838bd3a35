#pragma once

#include <epoxy/gl.h>

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "march/pixel_box.h"
#include "view/picture_maker.h"

namespace psivox::view {

/// How two pictures are shown.
enum class Comparison { none, wipe, difference };

/// How the screen shows radiance. None of it belongs to the scene.
struct DisplaySettings {
  Comparison comparison = Comparison::none;
  double divider = 0.5;  ///< part of the width
  Display display;       ///< of radiance
  double gain = 10;      ///< of a difference
  glm::dvec3 background{0};
  bool operator==(const DisplaySettings&) const = default;
};

/// The pictures, and the window's textures that show them. Radiance is encoded once, in the
/// resolution of the picture, by the code that writes it to a PNG.
class PictureDisplay {
 public:
  PictureDisplay();

  void set_preview(PicturePart picture);
  /// Drops the parts of older wishes.
  void add_part(const PicturePart& part);
  /// That wish's exact picture, with 0 where its parts have not come. Unset if none has.
  std::optional<Image> exact(std::uint64_t number, std::size_t side) const;

  void draw(const glm::ivec2& size, const DisplaySettings& settings);

 private:
  /// A texture of sRGB codes.
  struct Screen {
    Screen() = default;
    ~Screen();
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;
    void fit(const glm::ivec2& wanted);
    void put(const PixelBox& part, std::span<const std::uint8_t> rgb);

    GLuint texture = 0, framebuffer = 0;
    glm::ivec2 size{0};
  };
  struct Side {
    Image preview, exact;
    std::uint64_t number = 0;     ///< the wish of `exact`; 0: none
    std::vector<PixelBox> parts;  ///< of `exact` that have come
    std::size_t encoded = 0;      ///< how many of them `refined` has
    Screen small, refined;        ///< the preview, and parts over the enlarged preview
  };
  /// What side `to` shows of a rectangle of both sides' pictures.
  std::vector<std::uint8_t> codes(std::size_t to, Image Side::*picture, const PixelBox& part) const;
  /// Completes the textures of a side in a window of that size; returns the one to show.
  const Screen& encode(std::size_t to, const glm::ivec2& size);

  std::array<Side, 2> sides_;
  DisplaySettings settings_;
  bool stale_ = true;  ///< all has to be encoded again
};

}  // namespace psivox::view
