#include "gl/lattice_pass.h"

#include <algorithm>

#include "gl/tables.h"

namespace psivox::gl {

LatticePass::LatticePass(const MarchSetup& setup, const GridTextures& textures,
                         const MarchProgram& program)
    : setup_(setup), textures_(textures), march_(program), target_(side, false, true) {
  march_.configure(setup_);
  march_.program().set("bricks_first", int(setup_.tables.size()));
}

void LatticePass::columns(std::span<const LatticeBrick> bricks, std::span<double> depths) const {
  textures_.bind(march_);
  for (std::size_t first = 0; first < bricks.size(); first += most_bricks)
    draw(bricks.subspan(first, std::min(bricks.size() - first, most_bricks)),
         depths.data() + first * lattice_depths_of_brick);
}

void LatticePass::draw(std::span<const LatticeBrick> bricks, double* depths) const {
  const int rows = (int(bricks.size()) + row_bricks - 1) / row_bricks;
  std::vector<glm::vec4> entries = setup_.tables;
  for (const LatticeBrick& brick : bricks) entries.emplace_back(glm::vec3(brick), 0.f);
  // the last row is drawn whole
  entries.resize(setup_.tables.size() + std::size_t(rows * row_bricks), entries.back());
  const Tables tables(entries);
  tables.bind(MarchProgram::tables_unit);
  target_.bind(0);
  triangle_.draw(march_.program(), side, rows);
  first_.resize(std::max(first_.size(), std::size_t(side) * std::size_t(rows)));
  last_.resize(first_.size());
  target_.read_picture(side, rows, first_.data(), side);
  target_.read_layers(side, rows, last_.data(), side);
  constexpr std::size_t columns = lattice_columns * lattice_columns;
  for (std::size_t i = 0; i < columns * bricks.size(); ++i)
    for (const glm::vec4& part : {first_[i], last_[i]})
      for (int n = 0; n < 4; ++n) *depths++ = double(part[n]);
}

}  // namespace psivox::gl
