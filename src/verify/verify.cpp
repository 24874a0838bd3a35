#include "psivox/verify.h"

#include <algorithm>
#include <cmath>

#include "psivox/draw.h"
#include "scene/transfer_function.h"
#include "verify/case.h"
#include "verify/made.h"

namespace psivox {
namespace {

// A ray's depth d has up to 40 roundings of 2^-24 (a length, values, their sum). They change A = 1
// - e^{-d} by 40 * 2^-24 * d e^{-d}, and d e^{-d} is at most 0.37.
constexpr double depth_bound = 1e-6;
constexpr char depth_reason[] = "a depth d to 40 roundings of 2^-24; d e^-d <= 0.37";
constexpr double sum_bound = 16 * 0x1p-24;

/// A field that varies only along x, by values at x = 0, 1, ...; it falls to 0 a voxel beyond both.
Field plate(int count, const std::function<double(int x)>& value,
            const glm::dmat4& m = glm::dmat4(1), const glm::ivec3& at = {0, 0, 0}) {
  const glm::ivec3 side(0, 30, 30);
  return make_field(
      {at - side, at + side + glm::ivec3(count - 1, 0, 0)},
      [&](glm::ivec3 v) { return float(value(v.x - at.x)); }, m);
}

/// Looks at a place of the plate's index space from another.
Scene at_plate(double K, glm::dvec3 from, glm::dvec3 to, const glm::dmat4& m = glm::dmat4(1)) {
  for (glm::dvec3* p : {&from, &to}) *p = glm::dvec3(m * glm::dvec4(*p, 1));
  Scene scene = looking(small_scene(24, K), from, to);
  scene.fov = 30;
  scene.luminance = {1, 0.5, 0.25};
  return scene;
}

/// A ramp anywhere: constant luminance, so that the picture is that of its depth, up to 50 times K
/// over `slope`, the voxels along a ray that a unit of the world crosses.
Case ramp(const std::string& name, double K, const glm::dvec3& from, const glm::dvec3& to,
          const glm::dmat4& m = glm::dmat4(1), double slope = 1, const glm::ivec3& at = {0, 0, 0}) {
  const Scene scene = at_plate(K, glm::dvec3(at) + from, glm::dvec3(at) + to, m);
  const Field field = plate(
      33, [](int x) { return 0.125 * std::min(x, 12); }, m, at);
  return {name, depth_reason, std::min(depth_bound, 50 * K / slope * 40 * 0x1p-24), 3.3 * K / slope,
          view_of(scene, field)};
}

/// It changes by 1.5 a voxel along each axis, over the diagonal of a cube of 2 voxels.
Case tent() {
  constexpr double K = 0.9, peak = 1.5;
  const glm::ivec3 at(8, 0, -8);
  const Field voxel = make_field({at, at}, [](glm::ivec3) { return float(peak); });
  const Scene scene = looking(small_scene(33, K), {20, 9, -1}, glm::dvec3(at), 3.0);
  return {"single voxel's tent", depth_reason, depth_bound, K * peak * 3 * std::sqrt(12.0),
          view_of(scene, voxel)};
}

/// Two balls in a box of 40 x 36 x 38 voxels. The larger is flat inside, so some bricks have a
/// single value.
Field balls() {
  return make_field({{0, 0, 0}, {39, 35, 37}}, [](glm::ivec3 v) {
    const auto ball = [p = glm::dvec3(v)](const glm::dvec3& c, double r) {
      return std::max(0.0, 1 - glm::dot(p - c, p - c) / (r * r));
    };
    return float(std::min(1.0, 2 * ball({18, 17, 17}, 18)) + 0.8 * ball({31, 8, 29}, 7));
  });
}

// Rays are placed to 64 * 2^-24 voxels: coordinates of at most 32 from the middle are rounded by 16
// * 2^-24, twice, in two pictures. Along a ray the balls rise and fall by 1 and by 0.8, at most
// 0.23 per voxel, and K = 0.1. R is at most 1.8, the largest L; it changes by twice the change of
// the depth, plus the change of L.
constexpr double change_per_voxel = 2 * 1.8 * 0.1 * 2 * (1 + 0.8) + 0.23;

Case glowing_balls(const std::string& name, std::optional<double> step) {
  Scene scene = looking(small_scene(32, 0.1), {95, 60, 70}, {20, 18, 19}, 60.0);
  scene.step = step;
  if (!step) scene.integrator = Integrator::cell_exact;
  return {name, "rays placed to 64 * 2^-24 voxels", 64 * 0x1p-24 * change_per_voxel,
          6 * change_per_voxel, view_of(scene, balls(), Glow::density)};
}

/// The balls through a function whose slope is at most 1/0.3, from where rays meet faces in many
/// ways.
Case back_to_front() {
  Scene scene = looking(small_scene(64, 0.1), {20, 18, 90}, {20, 18, 19});
  scene.azimuth = 53;
  scene.elevation = 20;
  scene.mode = Mode::back_to_front;
  View view = view_of(scene, balls(), Glow::density);
  view.medium.transfer = std::make_shared<const TransferFunction>(
      std::vector<TransferPoint>{{0.1, 0, {}}, {0.4, 1, {}}, {0.7, 0.2, {}}}, false);
  return {"back to front", "sums up to 1.8: 32 roundings of 2^-24", 1.8 * 2 * sum_bound,
          6 * change_per_voxel / 0.3, view};
}

/// L = value on a ramp, along x. It is sensitive once to a step of the ramp in L and twice to the
/// depth, with L up to 1.75.
Case glowing_ramp(const std::string& rule, Integrator id, std::optional<double> step) {
  constexpr double K = 0.6;
  Scene scene = looking(small_scene(8, K), {-40, 0.4, 0.3}, {0, 0.4, 0.3}, 5.0);
  scene.integrator = id;
  scene.step = step;
  const Field ramp = plate(33, [](int x) { return 0.125 * std::min(x, 14); });
  return {"ramp that glows, " + rule, "256 segments' sums: 16 roundings of 2^-24", sum_bound,
          0.125 + 2 * 1.75 * K * 3.5, view_of(scene, ramp, Glow::density)};
}

/// Attenuation and luminance rise within a voxel to an opaque end; psi-exact integrates that
/// exactly. R is (pi/2K)^(1/2) times the root of the slope, below 1.3e-3, from a depth of K^(-1/2)
/// voxels. Of the hardware filter only A tells anything.
Case opaque_end() {
  constexpr double K = 1e6;
  Scene scene = at_plate(K, {-20, 2, 3}, {4, 0, 0});
  scene.fov = 25;
  scene.integrator = Integrator::psi_exact;
  scene.luminance = {1, 1, 1};
  return {"opaque end that glows", "rays placed to 64 * 2^-24 voxels of the K^-1/2 that glow",
          sum_bound + 1.3e-3 * 64 * 0x1p-24 * std::sqrt(K), 4,
          view_of(scene, plate(25, [](int) { return 1; }), Glow::density)};
}

/// A ramp whose value passes the tent's three knots inside cells. Segments end at the knots, so
/// each depth is exact. The tent's slope is 1/2.
Case transfer_tent() {
  constexpr double K = 0.25;
  const Scene scene = at_plate(K, {-28, 3.3, 1.8}, {12, 0.3, -0.2});
  View view = view_of(scene, plate(24, [](int x) { return 0.375 * (x + 1); }));
  view.scene.split_knots = true;
  const glm::dvec3 red(1, 0.5, 0.25);
  view.medium.transfer = std::make_shared<const TransferFunction>(
      std::vector<TransferPoint>{{2, 0, red}, {4, 1, red}, {6, 0, red}}, false);
  return {"ramp under a tent function", depth_reason, depth_bound, K * 0.5 * 2 * 9 * 1.15, view};
}

/// A slab that emits up to 1.3 without attenuating: A = 0.
Case emitting_slab() {
  View view = view_of(at_plate(0, {-40, 3, 2}, {6, 0, 0}), plate(12, [](int) { return 2; }));
  view.medium.emission = {{view.medium.density, 0.05}};
  return {"emission alone", "an integral up to 1.3 to 40 roundings of 2^-24", 1.3 * 40 * 0x1p-24,
          0.05 * 4 * 1.15, view};
}

/// Along the light. L changes by a voxel's K v, and the depth counts twice, times L below 1.
Case lit_ramp() {
  constexpr double K = 0.12;
  Scene scene = looking(small_scene(8, K), {-40, 0.4, 0.3}, {0, 0.4, 0.3}, 5.0);
  scene.lights = {{{1, 0, 0}, {1, 0.5, 0.25}}};
  const Field ramp = plate(20, [](int x) { return 0.25 * std::min(x + 1, 8); });
  return {"ramp lit from the front", "L <= 1 to 40 roundings, 64 segments' sums to 16",
          depth_bound + sum_bound, K * 2 + 2 * K * 4, view_of(scene, ramp)};
}

Case by_rule(Case c) {
  c.by_rule = true;
  return c;
}

}  // namespace

std::vector<Case> verify_cases() {
  const auto moved = [](double scale, const glm::dvec3& by) {
    return glm::translate(glm::scale(glm::dmat4(1), glm::dvec3(scale)), by);
  };
  const glm::ivec3 far(1'000'000, -1'000'003, 999'998);
  const glm::dvec3 front(-23.5, 3.3, 1.8), middle(16.5, 0.3, -0.2);
  return {
      ramp("thin ramp", 1e-7, front, middle),
      ramp("rotated, sheared, anisotropic", 0.05, front, middle, sheared, 3),
      ramp("origin 1e6 away", 0.05, front, middle, moved(1, {1e6, -1e6, 1e6})),
      ramp("voxels 1e6 from index 0", 5e-6, front, middle, moved(1e4, -glm::dvec3(far)), 1e-4, far),
      ramp("voxels of 1e-4", 500, front, middle, moved(1e-4, {0, 0, 0}), 1e4),
      ramp("camera inside", 0.05, {12, 0.4, -0.7}, {13, 0.5, -0.5}),
      tent(),
      glowing_balls("balls that glow, cells", {}),
      by_rule(glowing_balls("balls that glow, uniform", 0.9)),
      by_rule(glowing_ramp("psi-weighted", Integrator::psi_weighted, {})),
      by_rule(glowing_ramp("psi-balanced", Integrator::psi_balanced, 0.5)),
      opaque_end(),
      transfer_tent(),
      emitting_slab(),
      by_rule(lit_ramp()),
      by_rule(back_to_front())};
}

double largest_difference(const Image& a, const Image& b) {
  const Comparison found = compare_images(a, b);
  return found.not_finite ? std::nan("") : found.max;
}

VerifyCase run_case(const Case& c, Marcher& gpu, Filter filter) {
  Session session(c.view);
  const auto cpu = c.by_rule ? open_double() : open_reference();
  const Image truth = session.draw(*cpu).image;
  Wish wish;
  wish.scene = c.view.scene;
  wish.scene->filter = filter;
  const Drawn drawn = session.draw(gpu, wish);
  return {c.name, c.reason, largest_difference(drawn.image, truth),
          c.bound + (filter == Filter::hardware ? c.weights / 256 : 0), drawn.stats.stuck};
}

std::size_t VerifyReport::failed() const {
  return std::size_t(std::ranges::count(cases, false, &VerifyCase::passed));
}

std::uint64_t VerifyReport::stuck() const {
  std::uint64_t sum = 0;
  for (const VerifyCase& c : cases) sum += c.stuck;
  return sum;
}

VerifyReport verify(const VerifyOptions& options) {
  const std::shared_ptr<Marcher> gpu = open_gpu({.device = options.device});
  VerifyReport report;
  report.renderer = description(*gpu);
  for (const Case& c : verify_cases()) {
    report.cases.push_back(run_case(c, *gpu, options.filter));
    if (options.progress) options.progress(report.cases.back());
  }
  return report;
}

std::string verify_note(Filter filter) {
  return filter == Filter::exact ? "filter exact: trilinear weights in float32"
                                 : "filter hardware: bounds are wider by 2^-8 of what a weight "
                                   "changes, since devices may round trilinear weights to 8 bits";
}

}  // namespace psivox
