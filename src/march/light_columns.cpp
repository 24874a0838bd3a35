#include "march/light_lattice.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
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
  Real value = 0;
  Real attenuation = 0;  ///< without the extinction; unless it is a function of the value
  bool vacuum = true;    ///< nothing is stored there: the value is not known
};

/// What all columns of a brick meet at a time.
template <typename Real>
struct Points {
  std::array<Real, count> value{}, attenuation{};
  std::array<bool, count> vacuum{};
  bool any_vacuum = false;

  Point<Real> of(std::size_t column) const {
    return {value[column], attenuation[column], vacuum[column]};
  }
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
      const Real width = high[c] - low[c], least = Real(1e-30);
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
        parts_(std::max(1, int(std::lround(0.5 / frame.spacing)))),
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

  /// Depths of a brick's columns, axis_v fastest, at its slices, which follow each other.
  void depths(const LatticeBrick& brick, double* to) {
    const Window window = window_of(brick);
    if (!density_.gather(window)) {
      std::fill_n(to, lattice_depths_of_brick, 0.0);
      return;
    }
    if (march_.with_gradient) knows_slope_ = gradient_.gather(window);
    if (inside_across(brick)) return integrate_all(brick, to);
    for (int column = 0; column < count; ++column)
      integrate(brick, column / lattice_columns, column % lattice_columns,
                to + column * lattice_slices);
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

  Place place(double at, int axis) const {
    return {at, frame_.domain.min[axis], frame_.domain.max[axis]};
  }
  Place place_along(double t) const { return place(frame_.first - frame_.side * t, frame_.axis); }

  Real attenuation(Real value, const Place& along, const Place& u, const Place& v) {
    if (!march_.with_gradient) return value;
    const bool sloping = knows_slope_ && gradient_.has(along, u, v);
    const Real slope = sloping ? gradient_.at(along, u, v) : 0;
    return Real(march_.classify(glsl::AtlasMarch::Sample(value, slope)).attenuation);
  }

  Point<Real> point(const LatticeBrick& brick, int i, int j, double t) {
    const glm::dvec2 at = across(brick, i, j, t);
    const Place along = place_along(t), u = place(at.x, frame_.axis_u),
                v = place(at.y, frame_.axis_v);
    if (!density_.has(along, u, v)) return {};
    const Real value = density_.at(along, u, v);
    return {value, attenuation(value, along, u, v), false};
  }

  void find_points(const LatticeBrick& brick, double t, Points<Real>& points) {
    Places& places = places_;
    places.along = place_along(t);
    for (int k = 0; k < lattice_columns; ++k) {
      const glm::dvec2 at = across(brick, k, k, t);
      places.u[std::size_t(k)] = place(at.x, frame_.axis_u);
      places.v[std::size_t(k)] = place(at.y, frame_.axis_v);
    }
    density_.at(places, points.value.data());
    points.any_vacuum = false;
    if (!density_.all_stored())
      for (std::size_t c = 0; c < count; ++c) {
        points.vacuum[c] = !density_.has(places.along, places.u[c / lattice_columns],
                                         places.v[c % lattice_columns]);
        points.any_vacuum |= points.vacuum[c];
      }
    if (by_function_) return;
    for (std::size_t c = 0; c < count; ++c)
      points.attenuation[c] = points.vacuum[c] ? 0
                                               : attenuation(points.value[c], places.along,
                                                             places.u[c / lattice_columns],
                                                             places.v[c % lattice_columns]);
  }

  Real by_value(const Point<Real>& point) {
    if (point.vacuum) return 0;
    return Real(march_.classify(glsl::AtlasMarch::Sample(point.value, 0.0)).attenuation);
  }

  /// Mean attenuation between two points by a function of the value: exact where the value is
  /// linear.
  Real function_mean(const Point<Real>& a, const Point<Real>& b) {
    if (a.vacuum || b.vacuum) return Real(0.5) * (by_value(a) + by_value(b));
    if (!march_.ramps) return Real(march_.transfer_average(a.value, b.value).attenuation);
    std::array<Real, 1> mean{};
    ramps_.add_means(std::array{a.value}, std::array{b.value}, Real(1), mean);
    return mean[0];
  }

  Real mean(const Point<Real>& front, const Point<Real>& middle, const Point<Real>& back) {
    if (by_function_)
      return Real(0.5) * (function_mean(front, middle) + function_mean(middle, back));
    return (front.attenuation + 4 * middle.attenuation + back.attenuation) / 6;
  }

  /// Adds `scale` times the means to the depths.
  void add_means(const Points<Real>& front, const Points<Real>& middle, const Points<Real>& back,
                 Real scale, std::array<Real, count>& depths) {
    const bool known = !front.any_vacuum && !middle.any_vacuum && !back.any_vacuum;
    if (by_function_ && march_.ramps && known) {
      ramps_.add_means(front.value, middle.value, Real(0.5) * scale, depths);
      ramps_.add_means(middle.value, back.value, Real(0.5) * scale, depths);
      return;
    }
    for (std::size_t c = 0; c < count; ++c)
      depths[c] += scale * mean(front.of(c), middle.of(c), back.of(c));
  }

  /// Whether none of a brick's columns crosses a face of the domain that lies along the axis.
  bool inside_across(const LatticeBrick& brick) const {
    const glm::dvec2 low = glm::dvec2(frame_.across(clip_.min)),
                     high = glm::dvec2(frame_.across(clip_.max));
    constexpr int last = lattice_columns - 1;
    for (const double t : {brick.z - 1.0, brick.z + 7.0})
      if (glm::any(glm::lessThan(across(brick, 0, 0, t), low)) ||
          glm::any(glm::greaterThan(across(brick, last, last, t), high)))
        return false;
    return true;
  }

  /// All columns at once, where they enter and leave the domain at slices, if at all.
  void integrate_all(const LatticeBrick& brick, double* to) {
    const int a = frame_.slice(clip_.min[frame_.axis]), b = frame_.slice(clip_.max[frame_.axis]);
    const int begin = std::max(std::min(a, b), brick.z - 1), end = std::max(a, b);
    std::array<Real, count> depths{};
    Points<Real> front, middle, back;
    if (begin < std::min(brick.z + 7, end)) find_points(brick, begin, front);
    for (int n = 0; n < lattice_slices; ++n) {
      const int slice = brick.z + n;
      for (int part = 0; part < parts_ && slice > begin && slice <= end; ++part) {
        const double length = 1.0 / parts_, from = slice - 1 + part * length;
        find_points(brick, from + 0.5 * length, middle);
        find_points(brick, from + length, back);
        add_means(front, middle, back, Real(scale_ * length), depths);
        std::swap(front, back);
      }
      for (std::size_t c = 0; c < count; ++c)
        to[c * lattice_slices + std::size_t(n)] = double(depths[c]);
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

  void integrate(const LatticeBrick& brick, int i, int j, double* to) {
    const glm::dvec2 in = inside(brick, i, j);
    const double begin = in.x, end = in.y;
    double t = std::max(double(brick.z - 1), begin), depth = 0;
    Point<Real> front;
    if (t < std::min(double(brick.z + 7), end)) front = point(brick, i, j, t);
    for (int n = 0; n < lattice_slices; ++n) {
      for (int part = parts_ - 1; part >= 0; --part) {
        const double next = std::min(brick.z + n - double(part) / parts_, end);
        if (!(next > t)) continue;
        const Point<Real> middle = point(brick, i, j, 0.5 * (t + next)),
                          back = point(brick, i, j, next);
        depth += scale_ * (next - t) * double(mean(front, middle, back));
        front = back;
        t = next;
      }
      to[n] = depth;
    }
  }

  const LatticeFrame& frame_;
  glsl::AtlasMarch march_;
  Values<Real> density_, gradient_;
  Places places_;             ///< that are looked up
  bool knows_slope_ = false;  ///< whether the gradient has values in the brick's window
  bool by_function_;
  /// That a column is integrated in from slice to slice. Look-ups along a column are as near as
  /// columns are: between faces of cells an error of either kind falls with the fourth power,
  /// across them with the second.
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
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, bricks.size(), 32), [&](const auto& some) {
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
