#include "gl/tiles.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <tuple>
#include <vector>

#include "psivox/error.h"

namespace psivox::gl {
namespace {

GLuint make_texture(GLenum format, int side) {
  GLuint texture = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &texture);
  glTextureStorage2D(texture, 1, format, side, side);
  glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

}  // namespace

TileTarget::TileTarget(int side, bool resumable, bool layers)
    : side_(side), sets_(resumable ? 2 : 1) {
  picture_ = make_texture(GL_RGBA32F, side);
  if (layers) layers_ = make_texture(GL_RGBA32F, side);
  glCreateFramebuffers(sets_, framebuffers_);
  for (int set = 0; set < sets_; ++set) {
    glNamedFramebufferTexture(framebuffers_[set], GL_COLOR_ATTACHMENT0, picture_, 0);
    GLenum buffers[6];
    for (GLenum i = 0; i < 6; ++i) buffers[i] = GL_COLOR_ATTACHMENT0 + i;
    if (layers)
      glNamedFramebufferTexture(framebuffers_[set], GL_COLOR_ATTACHMENT1, layers_, 0);
    else
      buffers[1] = GL_NONE;
    for (GLuint i = 0; resumable && i < 4; ++i) {
      states_[set][i] = make_texture(GL_RGBA32I, side);
      glNamedFramebufferTexture(framebuffers_[set], GL_COLOR_ATTACHMENT2 + i, states_[set][i], 0);
    }
    glNamedFramebufferDrawBuffers(framebuffers_[set], resumable ? 6 : 2, buffers);
  }
}

TileTarget::~TileTarget() {
  glDeleteFramebuffers(sets_, framebuffers_);
  glDeleteTextures(1, &picture_);
  glDeleteTextures(1, &layers_);
  for (const auto& set : states_) glDeleteTextures(4, set);
}

void TileTarget::bind(int set) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffers_[set]);
  const auto bind_image = [](GLuint unit, GLuint texture, GLenum format) {
    glBindImageTexture(unit, texture, 0, GL_FALSE, 0, GL_WRITE_ONLY, format);
  };
  bind_image(0, picture_, GL_RGBA32F);
  bind_image(1, layers_, GL_RGBA32F);  // 0: what is written there is lost
  if (sets_ == 1) return;
  for (GLuint i = 0; i < 4; ++i) {
    glBindTextureUnit(i, states_[1 - set][i]);
    bind_image(2 + i, states_[set][i], GL_RGBA32I);
  }
}

void TileTarget::read_picture(int width, int height, glm::vec4* pixels, int stride) const {
  read(GL_COLOR_ATTACHMENT0, width, height, pixels, stride);
}

void TileTarget::read_layers(int width, int height, glm::vec4* pixels, int stride) const {
  read(GL_COLOR_ATTACHMENT1, width, height, pixels, stride);
}

void TileTarget::read(GLenum attachment, int width, int height, glm::vec4* pixels, int stride) {
  glReadBuffer(attachment);
  glPixelStorei(GL_PACK_ROW_LENGTH, stride);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, pixels);
  glPixelStorei(GL_PACK_ROW_LENGTH, 0);
}

bool TileTarget::all_done(int width, int height, int set, bool first_pass) {
  std::vector<glm::ivec4> values(std::size_t(width) * std::size_t(height));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[set]);
  glReadBuffer(GL_COLOR_ATTACHMENT5);
  glReadPixels(0, 0, width, height, GL_RGBA_INTEGER, GL_INT, values.data());
  const auto ended = [](const glm::ivec4& ray) { return (ray.z & 1) == 1; };
  const auto stands = [&](const glm::ivec4& before, const glm::ivec4& after) {
    return ended(before) == ended(after) && before.w == after.w;
  };
  const bool all = std::all_of(values.begin(), values.end(), ended);
  if (!all && !first_pass && std::equal(rays_.begin(), rays_.end(), values.begin(), stands))
    throw Error(ExitCode::graphics,
                "the device's rays stand still: a pass moved none of them; try another --device or "
                "driver, and psivox verify");
  rays_ = std::move(values);
  return all;
}

int TileTarget::draw_passes(const MarchProgram& march, int width, int height,
                            const std::function<void()>& draw) {
  int passes = 0;
  do {
    bind(passes & 1);
    march.program().set("first_pass", passes == 0);
    draw();
    ++passes;
  } while (march.key().resumable && !all_done(width, height, (passes - 1) & 1, passes == 1));
  return passes;
}

TileOrder::TileOrder(const PixelBox& pixels, const glm::ivec2& first, int largest)
    : pixels_(pixels), first_(first - pixels.origin) {
  for (int y = 0; y < pixels.size.y; y += largest)
    for (int x = 0; x < pixels.size.x; x += largest) push({x, y}, largest);
}

bool TileOrder::later(const Block& a, const Block& b) {
  return std::tie(a.distance, a.origin.y, a.origin.x) >
         std::tie(b.distance, b.origin.y, b.origin.x);
}

void TileOrder::push(const glm::ivec2& origin, int side) {
  if (origin.x >= pixels_.size.x || origin.y >= pixels_.size.y) return;
  const glm::dvec2 low(origin), high(origin + side);
  const glm::dvec2 away = first_ - glm::clamp(first_, low, high);
  blocks_.push_back({origin, side, away.x * away.x + away.y * away.y});
  std::push_heap(blocks_.begin(), blocks_.end(), later);
}

PixelBox TileOrder::take(int side) {
  while (true) {
    std::pop_heap(blocks_.begin(), blocks_.end(), later);
    const Block block = blocks_.back();
    blocks_.pop_back();
    if (block.side <= side)
      return {pixels_.origin + block.origin,
              glm::min(glm::ivec2(block.side), pixels_.size - block.origin)};
    const int half = block.side / 2;
    for (const glm::ivec2 corner : {glm::ivec2(0), {half, 0}, {0, half}, {half, half}})
      push(block.origin + corner, half);
  }
}

}  // namespace psivox::gl
