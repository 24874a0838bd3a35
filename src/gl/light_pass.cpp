#include "gl/light_pass.h"

#include <algorithm>

#include "gl/tables.h"
#include "march/light.h"

namespace psivox::gl {
namespace {

ProgramKey key_of(const MarchSetup& setup, const AtlasTextures& density,
                  const AtlasTextures* gradient, bool resumable) {
  ProgramKey key{setup.constants};
  key.buffers[0] = density.buffers();
  key.texels_per_buffer = density.texels_per_buffer();
  if (gradient) {
    key.buffers[3] = gradient->buffers();
    // of the one with several buffers it is the device's limit
    key.texels_per_buffer = std::max(key.texels_per_buffer, gradient->texels_per_buffer());
  }
  key.resumable = resumable;
  return key;
}

}  // namespace

LightPass::LightPass(const View& view, const MediumAtlas& atlas, const AtlasTextures& density,
                     const AtlasTextures* gradient)
    : LightPass(make_march_setup(light_march(view), atlas), density, gradient) {}

LightPass::LightPass(MarchSetup setup, const AtlasTextures& density, const AtlasTextures* gradient)
    : setup_(std::move(setup)),
      density_(density),
      gradient_(gradient),
      resumable_(setup_.parameters.max_turns > turns_per_pass(setup_)),
      march_(key_of(setup_, density, gradient, resumable_), "light.frag"),
      target_(side, resumable_, false) {
  MarchParameters& p = setup_.parameters;
  p.max_turns = std::min(p.max_turns, turns_per_pass(setup_));
  glCreateVertexArrays(1, &vertex_array_);
  march_.configure(setup_);
  march_.program().set("blocks_first", int(setup_.tables.size()));
}

LightPass::~LightPass() { glDeleteVertexArrays(1, &vertex_array_); }

std::vector<double> LightPass::depths(std::span<const glm::ivec3> origins) const {
  std::vector<double> result;
  result.reserve(origins.size() * side);
  density_.bind(march_.grid_unit(0));
  if (gradient_) gradient_->bind(march_.grid_unit(3));
  glBindVertexArray(vertex_array_);
  glUseProgram(march_.program().id());
  for (std::size_t first = 0; first < origins.size(); first += side)
    append(origins.subspan(first, std::min(origins.size() - first, std::size_t(side))), result);
  return result;
}

void LightPass::append(std::span<const glm::ivec3> origins, std::vector<double>& depths) const {
  std::vector<glm::vec4> entries = setup_.tables;
  for (const glm::ivec3& origin : origins)
    entries.emplace_back(glm::vec3(origin - setup_.origin), 0.f);
  const Tables tables(entries);
  tables.bind(MarchProgram::tables_unit);
  const int rows = int(origins.size());
  int passes = 0;
  do {
    target_.bind(passes & 1);
    glViewport(0, 0, side, rows);
    march_.program().set("first_pass", passes == 0);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    ++passes;
  } while (resumable_ && !target_.all_done(side, rows, (passes - 1) & 1));
  target_.bind((passes - 1) & 1);
  std::vector<glm::vec4> picture(std::size_t(side) * std::size_t(rows));
  target_.read_picture(side, rows, picture.data(), side);
  for (const glm::vec4& texel : picture) depths.push_back(double(texel.x));
}

}  // namespace psivox::gl
