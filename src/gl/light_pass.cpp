#include "gl/light_pass.h"

#include <algorithm>

#include "gl/tables.h"
#include "march/light.h"

namespace psivox::gl {

LightPass::LightPass(const View& view, const GridTextures& textures)
    : LightPass(make_march_setup(light_march(view), textures.atlas()), textures) {}

LightPass::LightPass(MarchSetup setup, const GridTextures& textures)
    : setup_(std::move(setup)),
      textures_(textures),
      march_(textures.key(setup_), "light.frag"),
      target_(side, march_.key().resumable, false) {
  march_.configure(setup_);
  march_.program().set("blocks_first", int(setup_.tables.size()));
}

std::vector<double> LightPass::depths(std::span<const glm::ivec3> origins) const {
  std::vector<double> result;
  result.reserve(origins.size() * side);
  textures_.bind(march_);
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
    march_.program().set("first_pass", passes == 0);
    triangle_.draw(march_.program(), side, rows);
    ++passes;
  } while (march_.key().resumable && !target_.all_done(side, rows, (passes - 1) & 1));
  target_.bind((passes - 1) & 1);
  std::vector<glm::vec4> picture(std::size_t(side) * std::size_t(rows));
  target_.read_picture(side, rows, picture.data(), side);
  for (const glm::vec4& texel : picture) depths.push_back(double(texel.x));
}

}  // namespace psivox::gl
