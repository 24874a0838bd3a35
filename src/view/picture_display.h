#pragma once

#include <epoxy/gl.h>

#include <array>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>

#include "gl/program.h"
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

/// A texture to draw into and to show.
struct Screen {
  GLuint texture = 0, framebuffer = 0;
  glm::ivec2 size{0};
};

/// The pictures in the window's context, and how they are shown. Radiance is encoded once, in the
/// resolution of the picture: on a software renderer the pixels of the screen cost most.
class PictureDisplay {
 public:
  /// Throws Error(graphics).
  PictureDisplay();
  ~PictureDisplay();

  void set_preview(const PreviewPicture& picture);
  /// Drops the parts of older wishes.
  void add_part(const ExactPart& part);
  /// Reads back the parts of that wish's exact picture that have come; alpha is -1 in the others.
  /// Unset if there are none.
  std::optional<Image> exact(std::uint64_t number, std::size_t side) const;

  void draw(const glm::ivec2& size, const DisplaySettings& settings);
  /// Builds the shader again from its folder. If that throws Error(graphics), the old one stays.
  void reload_shader();

 private:
  struct Side {
    GLuint preview = 0, exact = 0;
    glm::ivec2 preview_size{0}, exact_size{0};
    std::uint64_t number = 0;  ///< the wish of `exact`; 0: none
    Screen encoded;            ///< the preview as the screen shows it
  };
  struct Part {
    std::size_t side;
    glm::ivec2 origin, size;
  };
  void keep_view(const OcioView& view);
  void encode(GLuint picture, GLuint other, const Screen& to, const glm::ivec2& origin,
              const glm::ivec2& size);
  void encode_previews();
  void show_previews(GLuint framebuffer, const glm::ivec2& size, bool flipped);
  void encode_exact(const Part& part);

  std::array<Side, 2> sides_;
  Screen screen_;  ///< previews, and over them the exact parts
  std::unique_ptr<gl::Program> program_;
  gl::Triangle triangle_;
  GLuint view_codes_ = 0;  ///< a table of view_'s codes; 0: sRGB
  OcioView view_;
  DisplaySettings settings_;
  bool stale_ = true;          ///< screen_ has to be drawn again
  std::vector<Part> pending_;  ///< parts that screen_ lacks
};

}  // namespace psivox::view
