#include "cell_walk.h"
#include "ray_radiance.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>

namespace psivox {
namespace {

// The transform into the grid subtracts numbers of the size of the world's origin and multiplies by
// the inverse transform. Wider arithmetic keeps the double result right to its last bits.
using Wide = long double;
using WideVec = glm::vec<3, Wide>;
using WideMat = glm::mat<3, 3, Wide>;

std::int64_t floor_divide(std::int64_t a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

glm::ivec3 middle_of(const Box& box) {
  glm::ivec3 middle;
  for (int i = 0; i < 3; ++i) middle[i] = int((std::int64_t{box.min[i]} + box.max[i]) >> 1);
  return middle;
}

}  // namespace

double nearest_to_middle(const Field& field, const WorldRay& ray) {
  const glm::dvec4 middle(glm::dvec3(middle_of(field.domain())), 1);
  const glm::dvec3 to_middle = glm::dvec3(field.world_from_index * middle) - ray.origin;
  return std::max(0.0, glm::dot(to_middle, ray.direction));
}

IndexRay make_index_ray(const Field& field, const WorldRay& ray, double t_middle, double t0,
                        double t1, bool nearest) {
  IndexRay r;
  if (field.active_box.empty()) return r;
  const Box domain = field.domain();
  r.anchor = middle_of(domain);

  const WideMat world_from_index(field.world_from_index);
  const WideMat index_from_world = glm::inverse(world_from_index);
  const WideVec translation(field.world_from_index[3]);
  const WideVec origin = (WideVec(ray.origin) - translation) - world_from_index * WideVec(r.anchor);
  const WideVec direction(ray.direction);
  r.P = glm::dvec3(index_from_world * (origin + Wide(t_middle) * direction));
  if (nearest) r.P += 0.5;
  r.D = glm::dvec3(index_from_world * direction);

  r.s_begin = t0 - t_middle;
  r.s_end = t1 - t_middle;
  for (int i = 0; i < 3; ++i) {
    if (r.D[i] == 0) {
      const bool inside = r.P[i] >= double(domain.min[i] - r.anchor[i]) &&
                          r.P[i] <= double(domain.max[i] - r.anchor[i]);
      if (!inside) r.s_end = -infinity;
      continue;
    }
    const double a = r.crossing(i, domain.min[i]), b = r.crossing(i, domain.max[i]);
    r.s_begin = std::max(r.s_begin, std::min(a, b));
    r.s_end = std::min(r.s_end, std::max(a, b));
  }
  return r;
}

CubeSteps::CubeSteps(const IndexRay& ray, int width, double s0, double s1)
    : ray_(&ray), width_(width), s1_(s1), begin_(s0) {
  for (int i = 0; i < 3; ++i) {
    const double p = ray.D[i] == 0 ? ray.P[i] : ray.P[i] + s0 * ray.D[i];
    const auto cell = std::int64_t(std::floor(p)) + ray.anchor[i];
    std::int64_t key = floor_divide(cell, width);
    next_[i] = infinity;
    if (ray.D[i] != 0) {
      // p is rounded. The right cube is the one whose far plane is the first that the ray meets
      // after s0.
      const int ahead = ray.D[i] > 0 ? 1 : -1;
      const int far = ray.D[i] > 0 ? 1 : 0;
      while (ray.crossing(i, (key + far) * width) <= s0) key += ahead;
      while (ray.crossing(i, (key + far - ahead) * width) > s0) key -= ahead;
      next_[i] = ray.crossing(i, (key + far) * width);
    }
    key_[i] = int(key);
  }
  find_end();
}

void CubeSteps::next() {
  begin_ = end_;
  for (int i = 0; i < 3; ++i) {
    if (next_[i] > begin_) continue;
    key_[i] += ray_->D[i] > 0 ? 1 : -1;
    const int far = ray_->D[i] > 0 ? 1 : 0;
    next_[i] = ray_->crossing(i, (std::int64_t{key_[i]} + far) * width_);
  }
  find_end();
}

void CubeSteps::find_end() { end_ = std::min(s1_, std::min(next_.x, std::min(next_.y, next_.z))); }

namespace {

bool all_zero(const CellBlock& block, int channels) {
  for (int x = 0; x <= 8; ++x)
    for (int y = 0; y <= 8; ++y)
      for (int z = 0; z <= 8; ++z)
        for (int c = 0; c < channels; ++c)
          if (block.value({x, y, z}, c) != 0) return false;
  return true;
}

/// False only if every corner of the cells [w key, w key + w), w = widths[level], is 0.
bool may_hold_values(const FieldIndex& index, std::size_t level, const glm::ivec3& key) {
  for (int i = 0; i < 8; ++i) {
    const glm::ivec3 cube = FieldIndex::widths[level] * (key + cube_corner(i));
    if (index.holds_any(int(level), cube) || index.stores(cube)) return true;  // a wider tile does
  }
  return false;
}

constexpr std::size_t cells_level = FieldIndex::widths.size();

}  // namespace

// 8 x 8 x 16 neighbouring blocks have distinct slots, which the rays of one image tile share.
BlockCache::BlockCache(const FieldIndex& index) : index_(&index), blocks_(1024) {
  for (CellBlock& block : blocks_) block.key = glm::ivec3(INT_MIN);  // no block has this key
}

const CellBlock& BlockCache::at(const glm::ivec3& key) {
  const int slot = (key.x & 7) | (key.y & 7) << 3 | (key.z & 15) << 6;
  CellBlock& block = blocks_[std::size_t(slot)];
  if (block.key != key) block = made(key);
  return block;
}

CellBlock BlockCache::made(const glm::ivec3& key) const {
  CellBlock made;
  made.key = key;
  bool stored = false;
  for (int i = 0; i < 8; ++i) {
    const FieldIndex::Block block = index_->block(8 * (key + cube_corner(i)));
    made.values[std::size_t(i)] = block.values;
    stored |= block.stored;
  }
  made.empty = !stored || all_zero(made, index_->field().channels);
  return made;
}

GridWalk::GridWalk(BlockCache& cache, const IndexRay& ray, bool nearest)
    : cache_(&cache),
      ray_(ray),
      nearest_(nearest),
      begin_(-infinity),
      end_(ray.hits() ? ray.s_begin : infinity) {}

void GridWalk::next() {
  if (steps_[0])
    steps_[level_]->next();
  else
    steps_[0].emplace(ray_, FieldIndex::widths[0], ray_.s_begin, ray_.s_end);
  find();
}

/// Goes from the current steps to the next stretch that has a length.
void GridWalk::find() {
  while (true) {
    const CubeSteps& steps = *steps_[level_];
    if (steps.done()) {
      if (level_ == 0) return enter_zeros(ray_.s_end, infinity, false);
      steps_[--level_]->next();
      continue;
    }
    if (!(steps.begin() < steps.end())) {
      steps_[level_]->next();
      continue;
    }
    if (level_ == cells_level) return enter_cell(steps);
    bool empty = false;
    if (level_ + 1 == cells_level) {
      block_ = &cache_->at(steps.key());
      empty = block_->empty;
    } else {
      empty = !may_hold_values(cache_->index(), level_, steps.key());
    }
    if (empty) return enter_zeros(steps.begin(), steps.end(), true);
    const int width = level_ + 1 == cells_level ? 1 : FieldIndex::widths[level_ + 1];
    steps_[level_ + 1].emplace(ray_, width, steps.begin(), steps.end());
    ++level_;
  }
}

void GridWalk::enter_zeros(double begin, double end, bool in_domain) {
  begin_ = begin;
  end_ = end;
  in_domain_ = in_domain;
  absent_ = false;
  block_ = nullptr;
  low_ = high_ = {};
}

void GridWalk::enter_cell(const CubeSteps& steps) {
  begin_ = steps.begin();
  end_ = steps.end();
  in_domain_ = true;
  absent_ = false;
  cell_ = steps.key();
  for (int c = 0; c < cache_->index().field().channels; ++c) {
    const auto i = std::size_t(c);
    corners_[i] = block_->corners(cell_, c);
    if (nearest_) corners_[i].fill(corners_[i][0]);
    if (std::ranges::any_of(corners_[i], [](double v) { return std::isnan(v); })) {
      absent_ = true;
      low_ = high_ = {};
      return;
    }
    const glm::dvec4 a = glm::make_vec4(&corners_[i][0]), b = glm::make_vec4(&corners_[i][4]);
    const glm::dvec4 low = glm::min(a, b), high = glm::max(a, b);
    low_[i] = std::min(std::min(low.x, low.y), std::min(low.z, low.w));
    high_[i] = std::max(std::max(high.x, high.y), std::max(high.z, high.w));
  }
}

bool GridWalk::all_zero() const {
  return low_ == std::array<double, 3>{} && high_ == std::array<double, 3>{};
}

// Coefficients are means of the field in the cell; rounding must not leave its corners' range, so
// that a cell of one value is exactly that.
Cubic GridWalk::along(double a, double b, int channel) const {
  if (!block_ || absent_) return {};
  Cubic c =
      cubic_along(corners_[std::size_t(channel)], ray_.in_cell(cell_, a), ray_.in_cell(cell_, b));
  for (double& v : c) v = std::clamp(v, low(channel), high(channel));
  return c;
}

}  // namespace psivox
