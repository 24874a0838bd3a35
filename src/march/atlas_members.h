// No include guard: expanded inside the struct AtlasMarch, which marches over brick atlases.
PerGrid<const BrickAtlas*> grids{};
PerGrid<const BrickCode*> brick_codes{};  ///< by slot; see read_as
const glm::vec4* tables = nullptr;

AtlasMarch() = default;
/// Setup and atlas must stay as long as this.
AtlasMarch(const MarchSetup& setup, const MediumAtlas& atlas)
    : grids(grids_of(atlas)), tables(setup.tables.data()) {
  configure(setup);
}

/// From now on texels are read as these codes would have them.
void read_as(const BrickCodes& given) {
  brick_codes[density_grid] = given.own.data();
  if (paired) brick_codes[luminance_grid] = given.beside.data();
}

/// A ray that leaves the domain through an edge may look up a cell behind it, an ulp before its
/// end. A device returns anything for what is beyond the table, too.
uint fetch_page(int grid, int i) const {
  const std::vector<std::uint32_t>& entries = grids[std::size_t(grid)]->pages.entries;
  return entries[std::min(std::size_t(i), entries.size() - 1)];
}
real fetch_constant(int grid, int i) const {
  return grids[std::size_t(grid)]->constants[std::size_t(i)];
}
real3 fetch_constant3(int grid, int i) const {
  const float* v = grids[std::size_t(grid)]->constants.data() + 3 * std::size_t(i);
  return {v[0], v[1], v[2]};
}
real4 fetch_table(int i) const { return real4(tables[i]); }
real fetch_texel(int grid, int i) const { return value(grid, i, std::size_t(i)); }
real3 fetch_texel3(int grid, int i) const {
  const std::size_t at = 3 * std::size_t(i);
  return {value(grid, i, at), value(grid, i, at + 1), value(grid, i, at + 2)};
}
real4 fetch_pair(int i) const {
  const real v = fetch_texel(density_grid, i);
  if (luminance_source == SOURCE_VECTOR) return real4(v, fetch_texel3(luminance_grid, i));
  const real x = fetch_texel(luminance_grid, i);
  return {v, x, x, x};
}
uint4 fetch_code(int i) const {
  const std::uint64_t* words = grids[density_grid]->codes.get() + std::size_t(i) * (paired ? 2 : 1);
  const std::uint64_t a = words[0], b = paired ? words[1] : 0;
  return {uint(a), uint(a >> 32), uint(b), uint(b >> 32)};
}
real real_of_bits(uint bits) const { return std::bit_cast<float>(bits); }
static bool is_nan(real v) { return v != v; }
// Filtering in hardware is what the GPU alone does; in double the weights are exact.
real filtered_texel(int, int, real3) const { return 0; }
real3 filtered_texel3(int, int, real3) const { return real3(0); }

#include "march/march_members.h"

private:
/// A channel's value, the i-th of the grid, at a texel.
real value(int grid, int texel, std::size_t i) const {
  const float* const plain = grids[std::size_t(grid)]->texels.get();
  const BrickCode* const codes = brick_codes[std::size_t(grid)];
  return codes ? rounded(codes[texel / brick_texels], plain[i]) : plain[i];
}
// This is rare. It is not inlined: the compiler would take twice as long for the march.
[[gnu::noinline]] static real rounded(const BrickCode& code, float value) {
  return real(code.rounded(value));
}
