#include "gl/light_pass.h"

#include <algorithm>

namespace psivox::gl {

LightPass::LightPass(const MarchSetup& setup, const GridTextures& textures,
                     const MarchProgram& program)
    : setup_(setup),
      textures_(textures),
      march_(program),
      target_(side, march_.key().resumable, false) {
  march_.configure(setup_);
  march_.program().set("blocks_first", int(setup_.tables.size()));
}

void LightPass::depths(const LightBlocks& blocks, const TakeDepths& take,
                       const Progress& progress) {
  textures_.bind(march_);
  std::vector<glm::vec4> picture(std::size_t(side) * side);
  in_batches(blocks, progress, [&](std::span<const std::size_t> some) {
    std::vector<glm::vec4> entries = setup_.tables;
    for (const std::size_t block : some)
      entries.emplace_back(glm::vec3(blocks.all[block] - setup_.origin), 0.f);
    const Tables tables(entries);
    tables.bind(MarchProgram::tables_unit);
    const int rows = int(some.size());
    const int passes = target_.draw_passes(march_, side, rows,
                                           [&] { triangle_.draw(march_.program(), side, rows); });
    target_.bind((passes - 1) & 1);
    target_.read_picture(side, rows, picture.data(), side);
    std::vector<double> depths(side);
    for (std::size_t k = 0; k < some.size(); ++k) {
      for (std::size_t i = 0; i < side; ++i) {
        depths[i] = double(picture[k * side + i].x);
        stuck_ += picture[k * side + i].w > 0;
      }
      take(some[k], depths);
    }
  });
}

}  // namespace psivox::gl
