#include "view/picture_display.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace psivox::view {
namespace {

GLuint make_texture(GLenum format, const glm::ivec2& size) {
  GLuint texture = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &texture);
  glTextureStorage2D(texture, 1, format, size.x, size.y);
  glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

void fit(GLuint& texture, glm::ivec2& size, const glm::ivec2& wanted) {
  if (texture && size == wanted) return;
  glDeleteTextures(1, &texture);
  texture = make_texture(GL_RGBA32F, wanted);
  size = wanted;
}

void fit(Screen& screen, const glm::ivec2& wanted) {
  if (screen.texture && screen.size == wanted) return;
  glDeleteTextures(1, &screen.texture);
  if (!screen.framebuffer) glCreateFramebuffers(1, &screen.framebuffer);
  screen.texture = make_texture(GL_RGBA8, wanted);
  screen.size = wanted;
  glNamedFramebufferTexture(screen.framebuffer, GL_COLOR_ATTACHMENT0, screen.texture, 0);
}

void remove(const Screen& screen) {
  glDeleteFramebuffers(1, &screen.framebuffer);
  glDeleteTextures(1, &screen.texture);
}

// A view's table: in each direction light from 0 to 128, four places to a factor of 2. There the
// codes lie 0.2/255 beside the view's, where it is as smooth as sRGB (tests/ocio_test.cpp).
constexpr int places = 65;
constexpr double darkest = 1.0 / 512, octaves = 16;

GLuint make_view_codes(const OcioView& view) {
  std::vector<float> codes;
  const auto light = [](int i) {
    return float(darkest * (std::exp2(octaves * i / (places - 1)) - 1));
  };
  for (int b = 0; b < places; ++b)
    for (int g = 0; g < places; ++g)
      for (int r = 0; r < places; ++r) codes.insert(codes.end(), {light(r), light(g), light(b)});
  show_by(view, codes);
  GLuint texture = 0;
  glCreateTextures(GL_TEXTURE_3D, 1, &texture);
  glTextureStorage3D(texture, 1, GL_RGB32F, places, places, places);
  glTextureSubImage3D(texture, 0, 0, 0, 0, places, places, places, GL_RGB, GL_FLOAT, codes.data());
  glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
    glTextureParameteri(texture, axis, GL_CLAMP_TO_EDGE);
  return texture;
}

constexpr float nothing[4] = {0, 0, 0, 0};
constexpr float missing[4] = {0, 0, 0, -1};

std::unique_ptr<gl::Program> build_program() {
  auto program =
      std::make_unique<gl::Program>("display.frag", "", std::map<std::string, std::string>{});
  program->set("picture", 0);
  program->set("other", 1);
  program->set("view_codes", 2);
  program->set("view_darkest", darkest);
  program->set("view_octaves", octaves);
  return program;
}

}  // namespace

PictureDisplay::PictureDisplay() : program_(build_program()) {
  for (Side& side : sides_) {
    fit(side.preview, side.preview_size, {1, 1});
    fit(side.exact, side.exact_size, {1, 1});
    glClearTexImage(side.preview, 0, GL_RGBA, GL_FLOAT, nothing);
    glClearTexImage(side.exact, 0, GL_RGBA, GL_FLOAT, missing);
  }
}

PictureDisplay::~PictureDisplay() {
  for (const Side& side : sides_) {
    glDeleteTextures(1, &side.preview);
    glDeleteTextures(1, &side.exact);
    remove(side.encoded);
  }
  remove(screen_);
  glDeleteTextures(1, &view_codes_);
}

void PictureDisplay::reload_shader() {
  glUseProgram(0);  // ImGui sets what was current again, after this has deleted it
  program_ = build_program();
  stale_ = true;
}

void PictureDisplay::set_preview(const PreviewPicture& picture) {
  Side& side = sides_[picture.side];
  const glm::ivec2 size{picture.image.width, picture.image.height};
  fit(side.preview, side.preview_size, size);
  glTextureSubImage2D(side.preview, 0, 0, 0, size.x, size.y, GL_RGBA, GL_FLOAT,
                      picture.image.rgba().data());
  stale_ = true;
  if (side.number != picture.number) side.number = 0;
}

void PictureDisplay::keep_view(const OcioView& view) {
  if (view == view_) return;
  glDeleteTextures(1, &view_codes_);
  view_codes_ = view.config.empty() ? 0 : make_view_codes(view);
  view_ = view;
}

void PictureDisplay::add_part(const ExactPart& part) {
  Side& side = sides_[part.side];
  if (side.number != part.number) {
    fit(side.exact, side.exact_size, part.picture_size);
    glClearTexImage(side.exact, 0, GL_RGBA, GL_FLOAT, missing);
    side.number = part.number;
    stale_ = true;
  }
  glTextureSubImage2D(side.exact, 0, part.origin.x, part.origin.y, part.size.x, part.size.y,
                      GL_RGBA, GL_FLOAT, part.rgba.data());
  pending_.push_back({part.side, part.origin, part.size});
}

std::optional<Image> PictureDisplay::exact(std::uint64_t number, std::size_t side) const {
  const Side& own = sides_[side];
  if (number == 0 || own.number != number) return {};
  const glm::ivec2 size = own.exact_size;
  std::vector<float> rgba(4 * std::size_t(size.x) * std::size_t(size.y));
  glGetTextureImage(own.exact, 0, GL_RGBA, GL_FLOAT, int(rgba.size() * sizeof(float)), rgba.data());
  return Image{size.x, size.y, {{"", {"R", "G", "B", "A"}, std::move(rgba)}}, {}};
}

void PictureDisplay::encode(GLuint picture, GLuint other, const Screen& to,
                            const glm::ivec2& origin, const glm::ivec2& size) {
  const bool difference = settings_.comparison == Comparison::difference;
  glBindFramebuffer(GL_FRAMEBUFFER, to.framebuffer);
  glEnable(GL_SCISSOR_TEST);
  glScissor(origin.x, origin.y, size.x, size.y);
  glDisable(GL_BLEND);
  for (GLuint i = 0; i < 3; ++i) glBindSampler(i, 0);
  glBindTextureUnit(0, picture);
  glBindTextureUnit(1, difference ? other : picture);
  if (view_codes_) glBindTextureUnit(2, view_codes_);
  program_->set("by_view", int(view_codes_ && !difference));
  program_->set("difference", int(difference));
  program_->set("exposure", settings_.display.factor());
  program_->set("tone_map", int(settings_.display.tone_map));
  program_->set("gain", settings_.gain);
  program_->set("background", settings_.background);
  triangle_.draw(*program_, to.size.x, to.size.y);
  glDisable(GL_SCISSOR_TEST);
}

void PictureDisplay::encode_previews() {
  const GLuint other = sides_[1].preview;
  for (Side& side : sides_) {
    fit(side.encoded, side.preview_size);
    encode(side.preview, other, side.encoded, {0, 0}, side.preview_size);
    if (settings_.comparison != Comparison::wipe) break;
  }
}

void PictureDisplay::show_previews(GLuint framebuffer, const glm::ivec2& size, bool flipped) {
  const bool wipe = settings_.comparison == Comparison::wipe;
  const int divider = wipe ? int(std::lround(settings_.divider * size.x)) : size.x;
  glDisable(GL_SCISSOR_TEST);
  for (std::size_t i = 0; i < (wipe ? 2u : 1u); ++i) {
    const Screen& from = sides_[i].encoded;
    glEnable(GL_SCISSOR_TEST);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    glScissor(i ? divider : 0, 0, i ? size.x - divider : divider, size.y);
    glBlitNamedFramebuffer(from.framebuffer, framebuffer, 0, 0, from.size.x, from.size.y, 0,
                           flipped ? size.y : 0, size.x, flipped ? 0 : size.y, GL_COLOR_BUFFER_BIT,
                           GL_LINEAR);
  }
  glDisable(GL_SCISSOR_TEST);
}

void PictureDisplay::encode_exact(const Part& part) {
  const bool wipe = settings_.comparison == Comparison::wipe;
  if (part.side == 1 && settings_.comparison == Comparison::none) return;
  int first = part.origin.x, last = part.origin.x + part.size.x;
  const int divider = int(std::lround(settings_.divider * screen_.size.x));
  if (wipe) (part.side == 0 ? last : first) = std::clamp(divider, first, last);
  if (first >= last) return;
  const std::size_t picture = wipe ? part.side : 0;
  if (sides_[picture].exact_size != screen_.size || sides_[picture].number == 0) return;
  if (settings_.comparison == Comparison::difference &&
      (sides_[1].exact_size != screen_.size || sides_[1].number == 0))
    return;
  encode(sides_[picture].exact, sides_[1].exact, screen_, {first, part.origin.y},
         {last - first, part.size.y});
}

void PictureDisplay::draw(const glm::ivec2& size, const DisplaySettings& settings) {
  if (!(settings == settings_)) stale_ = true;
  settings_ = settings;
  keep_view(settings.display.ocio);
  const bool refining =
      (sides_[0].number && sides_[0].exact_size == size) ||
      (sides_[1].number && sides_[1].exact_size == size && settings.comparison != Comparison::none);
  if (!refining) {
    if (stale_) encode_previews();
    show_previews(0, size, true);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glViewport(0, 0, size.x, size.y);
    return;
  }
  if (stale_ || screen_.size != size) {
    fit(screen_, size);
    encode_previews();
    show_previews(screen_.framebuffer, size, false);
    pending_ = {{0, {0, 0}, size}, {1, {0, 0}, size}};
    stale_ = false;
  }
  for (const Part& part : pending_) encode_exact(part);
  pending_.clear();
  glBlitNamedFramebuffer(screen_.framebuffer, 0, 0, 0, size.x, size.y, 0, size.y, size.x, 0,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, size.x, size.y);
}

}  // namespace psivox::view
