#include "march/light_lattice.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <memory>

#include "field/index_space.h"
#include "march/atlas_march.h"
#include "march/column_values.h"
#include "march/march_parameters.h"

namespace psivox {
namespace columns {

/// Columns of a brick.
constexpr int count = lattice_columns * lattice_columns;

/// What a column meets at a point.
template <typename Real>
struct Point {
  Real value;
  bool stored;  ///< the value is known
};

/// What N columns meet at a time.
template <typename Real, std::size_t N>
struct Points {
  std::array<Real, N> value;
  std::array<Real, N>
      attenuation;             ///< without the extinction; unless it is a function of the value
  std::array<bool, N> stored;  ///< the value is known
  bool all_stored = true;

  bool is_stored(std::size_t column) const { return all_stored || stored[column]; }
  Point<Real> of(std::size_t column) const { return {value[column], is_stored(column)}; }
};

/// A function as a constant and ramps, each 0 up to its knot and linear from there on.
template <typename Real>
struct Ramps {
  Real base = 0;
  std::array<Real, 4> knots{}, slopes{};

  /// Adds `scale` times the means over values that are linear from `front` to `back`: of a ramp
  /// whose knot is between the ends only a part counts.
  template <std::size_t N>
  void add_means(const std::array<Real, N>& front, const std::array<Real, N>& back, Real scale,
                 std::array<Real, N>& to) const {
    std::array<Real, N> low, high, per_width, sum{};
    for (std::size_t c = 0; c < N; ++c) {
      low[c] = std::min(front[c], back[c]);
      high[c] = std::max(front[c], back[c]);
      const Real width = high[c] - low[c], least = Real(1e-37);
      per_width[c] = 1 / std::max(width, least);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const Real knot = knots[k], slope = slopes[k];
      for (std::size_t c = 0; c < N; ++c) {
        const Real to_low = low[c] - knot, to_high = high[c] - knot;
        const Real at_low = std::max(to_low, Real(0)), at_high = std::max(to_high, Real(0));
        const Real part = at_high * per_width[c];
        sum[c] += slope * (at_low + at_high * std::min(part, Real(1)));
      }
    }
    for (std::size_t c = 0; c < N; ++c) to[c] += scale * (base + Real(0.5) * sum[c]);
  }
};

/// Integrates the columns of bricks.
template <typename Real>
class Integration {
 public:
  Integration(const LatticeFrame& frame, const MarchSetup& setup, const MediumAtlas& atlas)
      : frame_(frame),
        march_(setup, atlas),
        density_(frame, march_, setup.origin, density_grid),
        gradient_(frame, march_, setup.origin, gradient_grid),
        by_function_(march_.transfer && !march_.with_gradient),
        parts_((march_.nearest ? 2 : 1) * std::max(1, int(std::lround(0.5 / frame.spacing)))),
        // a function may attenuate up to the faces of its own grid's domain
        clip_(march_.transfer ? Box{march_.density_field_min + setup.origin,
                                    march_.density_field_max + setup.origin}
                              : frame.domain),
        scale_(march_.extinction * frame.length / march_.world_unit) {
    ramps_.base = Real(march_.ramp_base);
    for (int k = 0; k < 4; ++k) {
      ramps_.knots[std::size_t(k)] = Real(march_.ramp_knots[k]);
      ramps_.slopes[std::size_t(k)] = Real(march_.ramp_slopes[k]);
    }
  }

  /// Depths of a brick at its slices, which follow each other: of its columns, axis_v fastest.
  void depths(const LatticeBrick& brick, double* to) {
    const Window window = window_of(brick);
    if (!density_.gather(window)) {
      std::fill_n(to, lattice_depths_of_brick, 0.0);
      return;
    }
    if (march_.with_gradient) knows_slope_ = gradient_.gather(window);
    integrate_all(brick, to);
    const std::array inside_u = inside_along(brick, 0), inside_v = inside_along(brick, 1);
    for (int i = 0; i < lattice_columns; ++i)
      for (int j = 0; j < lattice_columns; ++j)
        if (!inside_u[std::size_t(i)] || !inside_v[std::size_t(j)])
          integrate(brick, i, j, to + i * lattice_columns + j);
  }

 private:
  /// Largest rounding error of a place [voxels].
  static constexpr double rounding = 1e-6;

  Window window_of(const LatticeBrick& brick) const {
    Window window;
    const int a = frame_.first - frame_.side * (brick.z - 1);
    window.first = std::min(a, a - frame_.side * lattice_slices);
    const glm::dvec2 near = frame_.origin + frame_.spacing * glm::dvec2(brick);
    const glm::dvec2 far = near + (lattice_columns - 1) * frame_.spacing;
    const glm::ivec2 least = frame_.across(frame_.domain.min),
                     most = frame_.across(frame_.domain.max) - 1;
    for (int p = 0; p < planes; ++p) {
      const double slice = frame_.slice(window.first + p);
      const glm::dvec2 back = slice * frame_.shear, reach = glm::abs(frame_.shear) + rounding;
      const auto cell = [&](const glm::dvec2& at) {
        return glm::clamp(glm::ivec2(cell_of(at.x), cell_of(at.y)), least, most);
      };
      window.low[std::size_t(p)] = cell(near - back - reach);
      window.high[std::size_t(p)] = cell(far - back + reach) + 1;
    }
    return window;
  }

  glm::dvec2 across(const LatticeBrick& brick, int i, int j, double t) const {
    return frame_.origin + frame_.spacing * glm::dvec2(brick.x + i, brick.y + j) - t * frame_.shear;
  }

  /// N x N columns, the first at a place across the light.
  template <std::size_t N>
  void find_points(const glm::dvec2& first, double t, Points<Real, N * N>& points) {
    const auto places = [&](double at, int axis) {
      return Places<Real, N>(at, frame_.spacing, frame_.domain.min[axis], frame_.domain.max[axis],
                             march_.nearest);
    };
    const Place along(frame_.first - frame_.side * t, frame_.domain.min[frame_.axis],
                      frame_.domain.max[frame_.axis], march_.nearest);
    const Places<Real, N> u = places(first.x, frame_.axis_u), v = places(first.y, frame_.axis_v);
    density_.at(along, u, v, points.value.data());
    points.all_stored = density_.all_stored() || density_.has(along, u, v, points.stored.data());
    if (march_.absent_voxels) leave_out_absent(points);
    if (by_function_) return;
    points.attenuation = points.value;
    if (march_.with_gradient) classify(along, u, v, points);
    if (!points.all_stored)
      for (std::size_t c = 0; c < N * N; ++c)
        if (!points.stored[c]) points.attenuation[c] = 0;
  }

  /// Between absent values there is vacuum.
  template <std::size_t M>
  static void leave_out_absent(Points<Real, M>& points) {
    if (points.all_stored) points.stored.fill(true);
    for (std::size_t c = 0; c < M; ++c) {
      if (!std::isnan(points.value[c])) continue;
      points.value[c] = 0;
      points.stored[c] = points.all_stored = false;
    }
  }

  /// The attenuation by a function of value and gradient.
  template <std::size_t N>
  void classify(const Place& along, const Places<Real, N>& u, const Places<Real, N>& v,
                Points<Real, N * N>& points) {
    std::array<Real, N * N> slopes{};
    std::array<bool, N * N> sloping;
    sloping.fill(knows_slope_);
    if (knows_slope_) {
      gradient_.at(along, u, v, slopes.data());
      if (!gradient_.all_stored()) gradient_.has(along, u, v, sloping.data());
    }
    for (std::size_t c = 0; c < N * N; ++c) {
      const Real slope = sloping[c] ? slopes[c] : Real(0);
      if (points.is_stored(c))
        points.attenuation[c] =
            Real(march_.classify(glsl::AtlasMarch::Sample(points.value[c], slope)).attenuation);
    }
  }

  Real by_value(const Point<Real>& point) {
    if (!point.stored) return 0;
    return Real(march_.classify(glsl::AtlasMarch::Sample(point.value, 0.0)).attenuation);
  }

  /// Mean attenuation between two points by a function of the value: exact where the value is
  /// linear.
  Real function_mean(const Point<Real>& a, const Point<Real>& b) {
    if (!a.stored || !b.stored) return Real(0.5) * (by_value(a) + by_value(b));
    if (!march_.ramps) return Real(march_.transfer_average(a.value, b.value).attenuation);
    std::array<Real, 1> mean{};
    ramps_.add_means(std::array{a.value}, std::array{b.value}, Real(1), mean);
    return mean[0];
  }

  /// Adds `scale` times the means to the depths.
  template <std::size_t M>
  void add_means(const Points<Real, M>& front, const Points<Real, M>& middle,
                 const Points<Real, M>& back, Real scale, std::array<Real, M>& depths) {
    if (!by_function_ && !march_.nearest) {
      for (std::size_t c = 0; c < M; ++c)
        depths[c] +=
            scale / 6 * (front.attenuation[c] + 4 * middle.attenuation[c] + back.attenuation[c]);
      return;
    }
    std::array<Real, M> means{};
    const bool by_ramps = march_.ramps && !march_.nearest;
    if (by_ramps) {
      ramps_.add_means(front.value, middle.value, Real(0.5) * scale, means);
      ramps_.add_means(middle.value, back.value, Real(0.5) * scale, means);
    }
    if (!by_ramps || !front.all_stored || !middle.all_stored || !back.all_stored)
      for (std::size_t c = 0; c < M; ++c) {
        if (by_ramps && front.is_stored(c) && middle.is_stored(c) && back.is_stored(c)) continue;
        if (!march_.nearest)
          means[c] =
              scale * Real(0.5) *
              (function_mean(front.of(c), middle.of(c)) + function_mean(middle.of(c), back.of(c)));
        else
          means[c] = scale * (by_function_ ? by_value(middle.of(c)) : middle.attenuation[c]);
      }
    for (std::size_t c = 0; c < M; ++c) depths[c] += means[c];
  }

  /// Which of a brick's columns, by their numbers along u (0) or v (1), cross no face of the domain
  /// that lies along the axis.
  std::array<bool, lattice_columns> inside_along(const LatticeBrick& brick, int axis) const {
    const int low = frame_.across(clip_.min)[axis], high = frame_.across(clip_.max)[axis];
    std::array<bool, lattice_columns> inside;
    for (int k = 0; k < lattice_columns; ++k) {
      const double a = across(brick, k, k, brick.z - 1.0)[axis],
                   b = across(brick, k, k, brick.z + 7.0)[axis];
      inside[std::size_t(k)] = std::min(a, b) >= low && std::max(a, b) <= high;
    }
    return inside;
  }

  /// All columns at once, as if they entered and left the domain at slices, if at all.
  void integrate_all(const LatticeBrick& brick, double* to) {
    const int a = frame_.slice(clip_.min[frame_.axis]), b = frame_.slice(clip_.max[frame_.axis]);
    const int begin = std::max(std::min(a, b), brick.z - 1), end = std::max(a, b);
    std::array<Real, count> depths{};
    Points<Real, count> some, middle, others;
    Points<Real, count>*front = &some, *back = &others;
    const auto find = [&](double t, Points<Real, count>& points) {
      find_points<lattice_columns>(across(brick, 0, 0, t), t, points);
    };
    if (begin < std::min(brick.z + 7, end)) find(begin, *front);
    for (int n = 0; n < lattice_slices; ++n, to += count) {
      const int slice = brick.z + n;
      for (int part = 0; part < parts_ && slice > begin && slice <= end; ++part) {
        const double length = 1.0 / parts_, from = slice - 1 + part * length;
        find(from + 0.5 * length, middle);
        find(from + length, *back);
        add_means(*front, middle, *back, Real(scale_ * length), depths);
        std::swap(front, back);
      }
      std::copy_n(depths.begin(), count, to);
    }
  }

  /// Where a column is inside the domain.
  glm::dvec2 inside(const LatticeBrick& brick, int i, int j) const {
    const glm::dvec2 start = across(brick, i, j, 0);
    glm::dvec3 from, way;
    const auto set = [&](int axis, double at, double step) { from[axis] = at, way[axis] = step; };
    set(frame_.axis, frame_.first, -frame_.side);
    set(frame_.axis_u, start.x, -frame_.shear.x);
    set(frame_.axis_v, start.y, -frame_.shear.y);
    return interval_in(clip_.min, clip_.max, from, way);
  }

  /// One column, at slices that are `count` depths apart.
  void integrate(const LatticeBrick& brick, int i, int j, double* to) {
    const glm::dvec2 in = inside(brick, i, j);
    const double begin = in.x, end = in.y;
    double t = std::max(double(brick.z - 1), begin), depth = 0;
    Points<Real, 1> front, middle, back;
    const auto find = [&](double at, Points<Real, 1>& points) {
      find_points<1>(across(brick, i, j, at), at, points);
    };
    if (t < std::min(double(brick.z + 7), end)) find(t, front);
    for (int n = 0; n < lattice_slices; ++n) {
      for (int part = parts_ - 1; part >= 0; --part) {
        const double next = std::min(brick.z + n - double(part) / parts_, end);
        if (!(next > t)) continue;
        find(0.5 * (t + next), middle);
        find(next, back);
        std::array<Real, 1> mean{};
        add_means(front, middle, back, Real(1), mean);
        depth += scale_ * (next - t) * double(mean[0]);
        front = back;
        t = next;
      }
      to[n * count] = depth;
    }
  }

  const LatticeFrame& frame_;
  glsl::AtlasMarch march_;
  Values<Real> density_, gradient_;
  bool knows_slope_ = false;  ///< whether the gradient has values in the brick's window
  bool by_function_;
  /// Number of parts in which a column is integrated from slice to slice. Look-ups along a column
  /// are then as close as columns are. Within cells either error falls with the fourth power of the
  /// distance, across faces with the second. Of the nearest voxels' values the middle of a part
  /// counts: half a slice lies in one voxel, unless the column leaves it sideways.
  int parts_;
  Box clip_;
  double scale_;       ///< optical depth of attenuation 1 over a slice
  Ramps<Real> ramps_;  ///< the function, where `ramps`
};

}  // namespace columns

template <typename Real>
LatticeColumns light_columns(const LatticeFrame& frame, const View& view, const MediumAtlas& atlas,
                             const Beam& beam) {
  const auto setup =
      std::make_shared<const MarchSetup>(make_march_setup(light_march(view, beam), atlas));
  return [&frame, &atlas, setup](std::span<const LatticeBrick> bricks, std::span<double> depths) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, bricks.size(), 2), [&](const auto& some) {
      columns::Integration<Real> integration(frame, *setup, atlas);
      for (std::size_t i = some.begin(); i != some.end(); ++i)
        integration.depths(bricks[i], depths.data() + i * lattice_depths_of_brick);
    });
  };
}

template LatticeColumns light_columns<float>(const LatticeFrame&, const View&, const MediumAtlas&,
                                             const Beam&);
template LatticeColumns light_columns<double>(const LatticeFrame&, const View&, const MediumAtlas&,
                                              const Beam&);

}  // namespace psivox
