// Orders of convergence after Etiene et al. 2014: one length shrinks at a time, in media that are
// formulas with exact pictures. docs/method.md quotes what this prints.

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "formula_march.h"
#include "made_fields.h"
#include "psivox/draw.h"
#include "psivox/integrators.h"
#include "smooth_ray.h"
#include "study/suite.h"

namespace psivox {
namespace {

/// An order, and the errors that it is fitted to.
struct Order {
  std::string rays;                   ///< where they begin and end
  std::string way;                    ///< the rule, and how else the picture is made
  double K = 0;                       ///< extinction: optical depth over a width of the medium
  double expected = 0;                ///< its order
  double floor = 0;                   ///< errors below it are rounding
  bool about = false;                 ///< the rule has an error that does not fall with the length
  std::vector<LengthError> errors{};  ///< RMS of the radiance, from coarse to fine
};

/// The ends of a ray. The medium is 8 units of x wide.
struct RayEnds {
  const char* name;
  double first, last;
  bool inside;
};
constexpr RayEnds ray_ends[] = {
    {"vacuum to vacuum", -48, 48, false},  // where e^-s^2 is 2e-16
    // the camera at s = -0.6, a face of the box at s = 0.9, both off every lattice
    {"from inside", -0.6 * 8 + 0.0123, 0.9 * 8 - 0.0077, true}};

double phase_rms(Integrator rule, const SmoothRay& medium, const RayEnds& ends, double h,
                 bool corrected) {
  constexpr int phases = 8;
  const FormulaRay ray{[&](double x) { return medium.tau(x); },
                       [&](double x) { return medium.L(x); }, ends.first, ends.last};
  const double exact = medium.radiance(ends.first, ends.last);
  ErrorSum sum;
  for (int i = 0; i < phases; ++i) {
    const double phase = h * (i + 0.37) / phases;
    sum.add(march_formula(rule, ray, {h, phase, corrected}).radiance - exact, sum.count);
  }
  return sum.rms();
}

Order step_row(Integrator rule, double K, const RayEnds& ends, bool corrected) {
  Order row{ends.name, std::string(info(rule).name) + (corrected ? ", end corrections" : ""), K};
  row.expected = rule == Integrator::psi_balanced ? (ends.inside && !corrected ? 2 : 4)
                 : rule == Integrator::porter_duff && ends.inside ? 1
                                                                  : 2;
  row.about = rule == Integrator::psi_fit || rule == Integrator::psi_table;
  row.floor = 1e-11;  // sums of up to 12,288 terms, each at most 1 and rounded by 1e-16
  const SmoothRay medium{K};
  for (double h = 1; h >= 1.0 / 128; h /= 2)
    row.errors.emplace_back(h / medium.scale, phase_rms(rule, medium, ends, h, corrected));
  return row;
}

// Orders in the size of voxels and of pixels come from pictures of the march in double.

// Pictures and voxels are stored in float32, whose rounding is 6e-8 of 1.
constexpr double picture_floor = 1e-6;

// --- voxels --------------------------------------------------------------------------------------

// tau = K e^{-p^2} and L = 1 + 0.6 sin(1.3 x + 0.4), with p in world units: every ray is a
// SmoothRay.
constexpr double bump_K = 3;

/// On the ray, s is the distance from the point nearest to the middle.
double bump_radiance(const WorldRay& ray) {
  const double nearest = -glm::dot(ray.origin, ray.direction);
  const glm::dvec3 middle = ray.origin + nearest * ray.direction;
  const SmoothRay on_ray{bump_K * std::exp(-glm::dot(middle, middle)), 1, 1.3 * ray.direction.x,
                         0.4 + 1.3 * middle.x};
  return on_ray.radiance(std::max(-nearest, -7.0), 7);
}

/// Samples a function of the world at voxels of width `size`, as far out as e^{-p^2} is above 1e-7.
std::shared_ptr<const Field> bump_voxels(double size,
                                         const std::function<double(const glm::dvec3&)>& f) {
  const int reach = int(std::ceil(4 / size));
  return share(make_field(
      {glm::ivec3(-reach), glm::ivec3(reach)},
      [&](glm::ivec3 v) { return float(f(size * glm::dvec3(v))); },
      glm::scale(glm::dmat4(1), glm::dvec3(size))));
}

Image picture_by(Marcher& marcher, const View& view) { return Session(view).draw(marcher).image; }

struct VoxelMethod {
  const char* name;
  Integrator rule;
  bool uniform;    ///< by constant steps, far finer than the finest voxels
  bool reference;  ///< by the reference instead of the march
};
constexpr double fine_step = 1.0 / 128;  // [world units]
constexpr VoxelMethod voxel_methods[] = {
    {"cell-exact", Integrator::cell_exact, false, false},
    {"psi-weighted, 2 segments a cell", Integrator::psi_weighted, false, false},
    {"psi-balanced, step 1/128", Integrator::psi_balanced, true, false},
    {"midpoint, step 1/128", Integrator::midpoint, true, false},
    {"the reference", Integrator::cell_exact, false, true}};

Image voxel_picture(View view, const VoxelMethod& method, double voxel) {
  if (method.reference) return picture_by(*open_reference(), view);
  view.scene.integrator = method.rule;
  view.scene.sampling = method.uniform ? Sampling::uniform : Sampling::cells;
  if (method.uniform) view.scene.step = fine_step / voxel;
  return picture_by(*open_double(), view);
}

/// The exact picture of a view of the bump. It depends on the camera alone.
std::vector<double> bump_picture(const View& view) {
  std::vector<double> radiances;
  const glm::ivec2 size = view.scene.resolution;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) radiances.push_back(bump_radiance(pixel_ray(view, x, y)));
  return radiances;
}

double bump_rms(const std::vector<double>& exact, const Image& image) {
  ErrorSum sum;
  for (std::size_t i = 0; i < exact.size(); ++i) sum.add(image.rgba()[4 * i] - exact[i], i);
  return sum.rms();
}

// --- pixels --------------------------------------------------------------------------------------

/// Bilinear across the picture and constant along z, so that voxels represent it exactly. Eight
/// voxels with L = 1 give 1 - e^{-8 K v}.
double sheet_value(double x, double y) { return 1 + 0.06 * x + 0.03 * y + 0.004 * x * y; }
constexpr double sheet_K = 0.25, sheet_width = 16;  // [voxels] that the picture shows
double sheet_radiance(double x, double y) { return -std::expm1(-8 * sheet_K * sheet_value(x, y)); }

/// Errors of the sheet's picture of `side` x `side` pixels: by the nearest pixel, bilinear between
/// pixels, and of the mean.
std::array<double, 3> sheet_errors(int side) {
  Scene scene = looking(small_scene(side, sheet_K), {0, 0, 40}, {0, 0, 0}, sheet_width);
  const View view = view_of(scene, make_field({{-12, -12, 0}, {12, 12, 7}}, [](glm::ivec3 v) {
                              return float(sheet_value(v.x, v.y));
                            }));
  const Image image = picture_by(*open_double(), view);
  const auto exact = [&](double x, double y) {
    const WorldRay ray = camera_ray(view.camera, view.scene.resolution, x, y);
    return sheet_radiance(ray.origin.x, ray.origin.y);
  };
  constexpr int parts = 4;  // sample points per pixel and axis
  ErrorSum nearest, bilinear, pixels;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      pixels.add(pixel(image, x, y, 0), 0);
      for (int i = 0; i < parts * parts; ++i) {
        const double u = (i % parts + 0.5) / parts, v = (double(i / parts) + 0.5) / parts;
        nearest.add(pixel(image, x, y, 0) - exact(x + u, y + v), 0);
        if (x + 1 == side || y + 1 == side)
          continue;  // the mean lies between the centres of four pixels
        const double above = std::lerp(double(pixel(image, x, y, 0)), pixel(image, x + 1, y, 0), u);
        const double below =
            std::lerp(double(pixel(image, x, y + 1, 0)), pixel(image, x + 1, y + 1, 0), u);
        bilinear.add(std::lerp(above, below, v) - exact(x + 0.5 + u, y + 0.5 + v), 0);
      }
    }
  const double half = sheet_width / 2;
  const double mean = gauss_sum(-half, half, 16, [&](double y) {
    return gauss_sum(-half, half, 16, [&](double x) { return sheet_radiance(x, y); });
  });
  return {nearest.rms(), bilinear.rms(),
          std::abs(pixels.mean() - mean / (sheet_width * sheet_width))};
}

std::vector<Order> step_orders() {
  std::vector<Order> rows;
  for (const RayEnds& ends : ray_ends)
    for (const double K : {0.3, 3.0, 30.0})
      for (const IntegratorInfo& rule : integrators) {
        if (!is_segment_rule(rule.id)) continue;
        rows.push_back(step_row(rule.id, K, ends, false));
        if (rule.id == Integrator::psi_balanced && ends.inside)
          rows.push_back(step_row(rule.id, K, ends, true));
      }
  return rows;
}

std::vector<Order> voxel_orders() {
  const Scene outside = looking(small_scene(24, bump_K), {6, 4, 5}, {0, 0, 0}, 3.0);
  const Scene inside = looking(small_scene(24, bump_K), {0.3, -0.2, 0.1}, {-1, 0.5, 0.3});
  std::vector<Order> rows;
  for (const Scene* scene : {&outside, &inside})
    for (const VoxelMethod& method : voxel_methods) {
      const char* rays = scene == &outside ? "vacuum to vacuum" : "from inside";
      rows.push_back({rays, method.name, bump_K, 2, picture_floor});
    }
  std::array<std::vector<double>, 2> exact_pictures;
  const int first = 1, last = 4;
  for (int level = first; level <= last; ++level) {
    const double voxel = 1.0 / (1 << level);
    const auto density =
        bump_voxels(voxel, [](const glm::dvec3& p) { return std::exp(-glm::dot(p, p)); });
    const auto luminance =
        bump_voxels(voxel, [](const glm::dvec3& p) { return 1 + 0.6 * std::sin(1.3 * p.x + 0.4); });
    auto row = rows.begin();
    for (const Scene* scene : {&outside, &inside}) {
      const View view = make_view(*scene, density, luminance);
      std::vector<double>& exact = exact_pictures[scene == &inside];
      if (exact.empty()) exact = bump_picture(view);
      for (const VoxelMethod& method : voxel_methods) {
        row->errors.emplace_back(voxel, bump_rms(exact, voxel_picture(view, method, voxel)));
        ++row;
      }
    }
  }
  return rows;
}

std::vector<Order> pixel_orders() {
  std::vector<Order> rows;
  for (const auto& [look_up, order] : {std::pair("the nearest pixel", 1),
                                       {"bilinear between pixels", 2},
                                       {"mean of the picture", 2}})
    rows.push_back({"vacuum to vacuum", look_up, 8 * sheet_K, double(order), picture_floor});
  for (int side = 8; side <= 128; side *= 2) {
    auto row = rows.begin();
    for (const double error : sheet_errors(side)) (row++)->errors.emplace_back(1.0 / side, error);
  }
  return rows;
}

// Four halvings: higher orders contribute at most 10 % of an order if the lengths are as fine as
// here.
TEST(Orders, AreThoseExpected) {
  std::vector<Order> rows = step_orders();
  EXPECT_EQ(rows.size(), 2u * 3 * 11 + 3);
  for (const auto& more : {voxel_orders(), pixel_orders()})
    rows.insert(rows.end(), more.begin(), more.end());
  for (const Order& row : rows) {
    const std::vector<LengthError> fitted = finest_four(row.errors, row.floor);
    ASSERT_EQ(fitted.size(), 4u) << row.way;
    const double observed = fitted_order(fitted);
    std::printf("  %-30s %-17s K %-4g expected %s%g, observed %.3f, errors %.2e to %.2e\n",
                row.way.c_str(), row.rays.c_str(), row.K, row.about ? "about " : "", row.expected,
                observed, fitted.front().second, fitted.back().second);
    // Convergence bounds the error of an approximate Psi
    EXPECT_NEAR(observed, row.expected, row.about ? 0.5 : 0.1)
        << row.way << ' ' << row.rays << ' ' << row.K;
  }
}

TEST(Orders, AreFittedToTheFinestAboveRounding) {
  std::vector<LengthError> errors;
  for (double h = 1; h > 1.0 / 100; h /= 2) errors.emplace_back(h, 3 * h * h * h);
  EXPECT_NEAR(fitted_order(errors), 3, 1e-12);
  const auto fitted = finest_four(errors, 1e-4);
  ASSERT_EQ(fitted.size(), 4u);
  EXPECT_EQ(fitted.back().first, 1.0 / 16);  // 3/32^3 is 9e-5
  EXPECT_EQ(finest_four(errors, 0.1).size(), 2u);
}

// --- beside other rules and another program ------------------------------------------------------

/// RMS of the radiance over the phases of the lattice, for the segment from `first` to `last`.
double rms(Integrator rule, const SmoothRay& field, double first, double last, double h,
           int phases = 16) {
  const FormulaRay ray{[&](double x) { return field.tau(x); }, [&](double x) { return field.L(x); },
                       first, last};
  ErrorSum sum;
  for (int i = 0; i < phases; ++i)
    sum.add(march_formula(rule, ray, {h, h * (i + 0.37) / phases}).radiance -
                field.radiance(first, last),
            sum.count);
  return sum.rms();
}

constexpr double far = 9 * 8;  // where exp(-s^2) is 7e-36: vacuum
constexpr std::array<double, 3> extinctions{0.3, 3, 30};

// psi-fit and psi-table have no order of their own. Their share of the back end is off by at most d
// however short the step; psi_rules_test measures d. That changes the picture by sum T (1 - zeta) d
// |L_f - L_b| <= d max|L_f - L_b| <= d h 0.6 1.3/8.
TEST(Convergence, ApproximationsFollowPsiExact) {
  struct Ends {
    double first, last, longest;  ///< of the ray, and of a step
  };
  for (const double K : extinctions)
    for (const auto& [rule, d] :
         {std::pair(Integrator::psi_fit, 4.7e-3), {Integrator::psi_table, 1.1e-4}})
      for (const Ends& ends :
           {Ends{-far, far, 1}, Ends{-0.6 * 8 + 0.0123, 0.9 * 8 - 0.0077, 1.0 / 8}})
        for (double h = ends.longest; h >= ends.longest / 16; h /= 2)
          EXPECT_NEAR(rms(rule, {K}, ends.first, ends.last, h),
                      rms(Integrator::psi_exact, {K}, ends.first, ends.last, h), d * h * 0.0975)
              << info(rule).name << " K " << K << ' ' << h;
}

/// Computed by another program in float64: 144 steps over 18, RMS over the lattice's phases. Given
/// to its two digits.
TEST(ConvergenceTable, OfAnotherProgram) {
  struct Row {
    Integrator rule;
    std::array<double, 3> error;  // K 0.3, 3, 30
  };
  const Row table[] = {{Integrator::porter_duff, {3.4e-5, 6.6e-4, 3.2e-4}},
                       {Integrator::midpoint, {3.4e-5, 6.6e-4, 3.2e-4}},
                       {Integrator::psi_weighted, {1.9e-4, 1.7e-4, 1.5e-3}},
                       {Integrator::psi_exact, {2.5e-4, 7.8e-5, 1.8e-3}},
                       {Integrator::psi_balanced, {1.6e-7, 4.3e-7, 7.8e-6}}};
  for (const Row& row : table)
    for (std::size_t i = 0; i < 3; ++i) {
      const double seen = rms(row.rule, {extinctions[i]}, -far, far, 1, 64);
      std::printf("  %-16s K %-4g %.3e (page: %.1e)\n", info(row.rule).name, extinctions[i], seen,
                  row.error[i]);
      EXPECT_NEAR(seen / row.error[i], 1, 0.05) << info(row.rule).name << ' ' << extinctions[i];
    }
}

}  // namespace
}  // namespace psivox
