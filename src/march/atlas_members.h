// No include guard: expanded inside the struct AtlasMarch, which marches over brick atlases.
PerGrid<const BrickAtlas*> grids{};
const glm::vec4* tables = nullptr;

AtlasMarch() = default;
/// Setup and atlas must stay as long as this.
AtlasMarch(const MarchSetup& setup, const MediumAtlas& atlas)
    : grids(grids_of(atlas)), tables(setup.tables.data()) {
  configure(setup);
}

uint fetch_page(int grid, int i) const {
  return grids[std::size_t(grid)]->pages.entries[std::size_t(i)];
}
real fetch_constant(int grid, int i) const {
  return grids[std::size_t(grid)]->constants[std::size_t(i)];
}
real3 fetch_constant3(int grid, int i) const {
  const float* v = grids[std::size_t(grid)]->constants.data() + 3 * std::size_t(i);
  return {v[0], v[1], v[2]};
}
real4 fetch_table(int i) const { return real4(tables[i]); }
real fetch_texel(int grid, int i) const { return value(grid, std::size_t(i)); }
real3 fetch_texel3(int grid, int i) const {
  const std::size_t at = 3 * std::size_t(i);
  return {value(grid, at), value(grid, at + 1), value(grid, at + 2)};
}
real4 fetch_pair(int i) const {
  const std::size_t at = std::size_t(i), first = luminance_source == SOURCE_VECTOR ? 3 * at : at;
  const real v = value(density_grid, at), x = value(luminance_grid, first);
  if (luminance_source != SOURCE_VECTOR) return {v, x, x, x};
  return {v, x, value(luminance_grid, first + 1), value(luminance_grid, first + 2)};
}
uint4 fetch_code(int i) const {
  const std::uint64_t* words = grids[density_grid]->codes.get() + std::size_t(i) * (paired ? 2 : 1);
  const std::uint64_t a = words[0], b = paired ? words[1] : 0;
  return {uint(a), uint(a >> 32), uint(b), uint(b >> 32)};
}
real real_of_bits(uint bits) const { return std::bit_cast<float>(bits); }
// Filtering in hardware is what the GPU alone does; in double the weights are exact.
real filtered_texel(int, int, real3) const { return 0; }
real3 filtered_texel3(int, int, real3) const { return real3(0); }

#include "march/march_members.h"

private:
real value(int grid, std::size_t i) const {
  const BrickAtlas& atlas = *grids[std::size_t(grid)];
  return atlas.texels32 ? atlas.texels32[i] : glm::unpackHalf1x16(atlas.texels16[i]);
}
