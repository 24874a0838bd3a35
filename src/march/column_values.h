#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <glm/common.hpp>
#include <vector>

#include "march/atlas_march.h"
#include "march/light_lattice.h"

namespace psivox::columns {

/// Planes of voxels that a brick's columns cross, from the slice before its first on.
inline constexpr int planes = lattice_slices + 1;

/// Copies a few values without a call.
inline void copy_few(const float* from, int length, float* to) {
  for (; length >= 4; length -= 4, from += 4, to += 4) std::memcpy(to, from, 4 * sizeof(float));
  if (length & 2) std::memcpy(to, from, 2 * sizeof(float));
  if (length & 1) to[length & 2] = from[length & 2];
}

/// A cell along an axis, and a place in it.
struct Place {
  int cell = 0;
  double part = 0;

  Place() = default;
  /// In the nearest cell of [first, end) if it is in none; `nearest`: at its nearest voxel.
  Place(double at, int first, int end, bool nearest)
      : cell(std::clamp(cell_of(at), first, end - 1)), part(at - cell) {
    if (nearest) part = part >= 0.5 ? 1 : 0;
  }
};

/// The places of N columns along one axis across the light.
template <typename Real, std::size_t N>
struct Places {
  std::array<int, N> cell;
  std::array<Real, N> part;
  bool consecutive = true;  ///< whether each column is in the cell after the previous one's

  /// `spacing` apart from `at` on, each in the nearest cell of [first, end) if it is in none.
  Places(double at, double spacing, int first, int end, bool nearest) {
    for (std::size_t k = 0; k < N; ++k) {
      const Place place(at + double(k) * spacing, first, end, nearest);
      cell[k] = place.cell;
      part[k] = Real(place.part);
      consecutive &= cell[k] == cell[0] + int(k);
    }
  }
};

/// Voxels of each plane that a brick's columns are interpolated from.
struct Window {
  int first = 0;  ///< coordinate of the lowest plane
  std::array<glm::ivec2, planes> low, high;
};

/// The values of a grid in a window, and whether the cells behind each voxel are stored.
template <typename Real>
class Values {
 public:
  Values(const LatticeFrame& frame, glsl::AtlasMarch& march, const glm::ivec3& origin, int grid)
      : frame_(frame), march_(march), origin_(origin), grid_(grid) {
    constexpr glm::ivec3 of_axes(brick_values * brick_values, brick_values, 1);
    stride_ = {of_axes[frame.axis], of_axes[frame.axis_u], of_axes[frame.axis_v]};
  }

  /// Returns whether any cell is stored.
  bool gather(const Window& window) {
    find_bricks(window);
    if (std::ranges::none_of(nodes_, stored)) return false;
    const bool all = std::ranges::all_of(nodes_, stored);
    std::size_t size = 0;
    for (int p = 0; p < planes; ++p) {
      Plane& plane = planes_[std::size_t(p)];
      plane.low = window.low[std::size_t(p)];
      plane.width = window.high[std::size_t(p)].y - plane.low.y + 1;
      plane.first = size;
      size +=
          std::size_t(plane.width) * std::size_t(window.high[std::size_t(p)].x - plane.low.x + 1);
    }
    if (values_.size() < size) values_.resize(size);
    all_stored_ = all;
    if (!all) {
      std::fill_n(values_.begin(), size, 0.0f);
      is_stored_.assign(size, 0);
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (stored(nodes_[i])) copy(window, nodes_[i], brick_at(i), all);
    first_ = window.first;
    return true;
  }

  bool all_stored() const { return all_stored_; }
  /// At N x N columns, v fastest.
  template <std::size_t N>
  void at(const Place& along, const Places<Real, N>& u, const Places<Real, N>& v, Real* to) const {
    const Plane& near = planes_[std::size_t(along.cell - first_)];
    const Plane* const far = along.part == 0 ? nullptr : &near + 1;
    std::array<Real, N> low{}, high{}, beyond;
    int cell = 0;
    for (std::size_t i = 0; i < N; ++i, to += N) {
      if (i == 0 || u.cell[i] != cell) {
        if (i > 0 && u.cell[i] == cell + 1)
          low = high;
        else
          along_v(near, far, Real(along.part), u.cell[i], v, low, beyond);
        cell = u.cell[i];
        along_v(near, far, Real(along.part), cell + 1, v, high, beyond);
      }
      for (std::size_t k = 0; k < N; ++k) to[k] = low[k] + (high[k] - low[k]) * u.part[i];
    }
  }

  /// Whether their cells are stored. Returns whether all are.
  template <std::size_t N>
  bool has(const Place& along, const Places<Real, N>& u, const Places<Real, N>& v, bool* to) const {
    const Plane& plane = planes_[std::size_t(along.cell - first_)];
    bool all = true;
    for (const int u_cell : u.cell)
      for (const int v_cell : v.cell) {
        *to = is_stored_[plane.at(u_cell, v_cell)] != 0;
        all &= *to++;
      }
    return all;
  }

 private:
  using Node = glsl::AtlasMarch::Node;

  struct Plane {
    glm::ivec2 low{0};
    int width = 0;
    std::size_t first = 0;

    std::size_t at(int u, int v) const {
      return first + std::size_t((u - low.x) * width + (v - low.y));
    }
  };

  /// Values at a row of columns, which are between voxels along v but not along u; between two
  /// planes unless `far` is null.
  template <std::size_t N>
  void along_v(const Plane& near, const Plane* far, Real part, int u, const Places<Real, N>& v,
               std::array<Real, N>& to, std::array<Real, N>& beyond) const {
    between(values_.data() + near.at(u, v.cell[0]), v, to);
    if (!far) return;
    between(values_.data() + far->at(u, v.cell[0]), v, beyond);
    for (std::size_t k = 0; k < N; ++k) to[k] += (beyond[k] - to[k]) * part;
  }

  template <std::size_t N>
  static void between(const float* from, const Places<Real, N>& v, std::array<Real, N>& to) {
    if (v.consecutive)
      for (std::size_t k = 0; k < N; ++k)
        to[k] = Real(from[k]) + (Real(from[k + 1]) - Real(from[k])) * v.part[k];
    else
      for (std::size_t k = 0; k < N; ++k) {
        const float* const low = from + (v.cell[k] - v.cell[0]);
        to[k] = Real(low[0]) + (Real(low[1]) - Real(low[0])) * v.part[k];
      }
  }

  static bool stored(const Node& node) { return node.kind != glsl::AtlasMarch::NODE_EMPTY; }

  /// The voxel, brick or size with those components along the frame's axes.
  glm::ivec3 turned(int along, int u, int v) const {
    glm::ivec3 voxel;
    voxel[frame_.axis] = along;
    voxel[frame_.axis_u] = u;
    voxel[frame_.axis_v] = v;
    return voxel;
  }

  /// Bricks with a value of the window, those whose last values alone are in it too.
  void find_bricks(const Window& window) {
    glm::ivec2 low = window.low[0], high = window.high[0];
    for (int p = 1; p < planes; ++p) {
      low = glm::min(low, window.low[std::size_t(p)]);
      high = glm::max(high, window.high[std::size_t(p)]);
    }
    bricks_ = {glm::ivec3(window.first - 1, low - 1) >> 3,
               glm::ivec3(window.first + planes - 1, high) >> 3};
    nodes_.clear();
    for (int w = bricks_.min.x; w <= bricks_.max.x; ++w)
      for (int u = bricks_.min.y; u <= bricks_.max.y; ++u)
        for (int v = bricks_.min.z; v <= bricks_.max.z; ++v) {
          const glm::ivec3 cell = 8 * turned(w, u, v);
          const glm::ivec3 near = glm::clamp(cell, frame_.domain.min, frame_.domain.max - 1);
          nodes_.push_back((cell >> 3) == (near >> 3) ? march_.find_stored(grid_, near - origin_)
                                                      : march_.no_node());
        }
  }
  glm::ivec3 brick_at(std::size_t i) const {
    const glm::ivec3 size = bricks_.max - bricks_.min + 1;
    const int k = int(i);
    return bricks_.min + glm::ivec3(k / (size.y * size.z), k / size.z % size.y, k % size.z);
  }

  /// A brick's values that are in the window. If all bricks are stored, its last ones are the
  /// next one's first.
  void copy(const Window& window, const Node& node, const glm::ivec3& brick, bool all) {
    const int last = all ? 7 : 8;
    const glm::ivec3 from = 8 * brick;
    for (int w = std::max(window.first, from.x);
         w <= std::min(window.first + planes - 1, from.x + last); ++w) {
      const auto p = std::size_t(w - window.first);
      const Plane& plane = planes_[p];
      const glm::ivec2 low = glm::max(plane.low, glm::ivec2(from.y, from.z));
      const glm::ivec2 high =
          glm::min(window.high[p], glm::ivec2(from.y, from.z) + glm::ivec2(last));
      if (high.y < low.y) continue;
      for (int u = low.x; u <= high.x; ++u) {
        const glm::ivec3 first = glm::ivec3(w, u, low.y) - from;
        const std::size_t to = plane.at(u, low.y);
        read_row(node, first, high.y - low.y + 1, values_.data() + to);
        if (!all && first.x < 8 && first.y < 8)
          std::fill_n(is_stored_.begin() + std::ptrdiff_t(to),
                      std::max(std::min(high.y - from.z, 7) - first.z + 1, 0), 1);
      }
    }
  }

  /// Some of a brick's values along v.
  void read_row(const Node& node, const glm::ivec3& first, int length, float* to) const {
    if (node.kind == glsl::AtlasMarch::NODE_CONSTANT) {
      std::fill_n(to, length, float(march_.fetch_constant(grid_, node.payload)));
      return;
    }
    const glm::ivec3 steps = stride_ * first;
    const std::size_t texel =
        std::size_t(node.payload) * brick_texels + std::size_t(steps.x + steps.y + steps.z);
    const float* const from = march_.grids[std::size_t(grid_)]->texels.get() + texel;
    if (stride_.z == 1)
      copy_few(from, length, to);
    else
      for (int i = 0; i < length; ++i) to[i] = from[i * brick_values];
  }

  const LatticeFrame& frame_;
  glsl::AtlasMarch& march_;
  glm::ivec3 origin_;
  int grid_;
  glm::ivec3 stride_{0};     ///< of a brick's texels along the axis, u and v
  Box bricks_;               ///< along the axis, u and v
  std::vector<Node> nodes_;  ///< of bricks_, v fastest
  int first_ = 0;            ///< coordinate of the first plane
  std::array<Plane, planes> planes_;
  std::vector<float> values_;
  bool all_stored_ = false;
  std::vector<std::uint8_t> is_stored_;  ///< unless all are
};

}  // namespace psivox::columns
