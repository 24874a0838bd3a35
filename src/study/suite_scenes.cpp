// The scenes of the precision suite.

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/trigonometric.hpp>

#include "base/text.h"
#include "base/text_file.h"
#include "scene/transfer_function.h"
#include "study/page.h"
#include "study/suite.h"
#include "verify/made.h"

namespace psivox {
namespace {

using Rules = std::vector<Integrator>;
constexpr Integrator porter_duff = Integrator::porter_duff;

const Rules value_rules{porter_duff, Integrator::midpoint, Integrator::psi_weighted,
                        Integrator::psi_balanced};
const Rules function_rules{porter_duff, Integrator::psi_weighted, Integrator::psi_balanced,
                           Integrator::preintegrated, Integrator::preintegrated_fast};
const std::vector<double> usual_steps{1, 0.5, 0.25, 0.125};
const std::vector<double> fine_steps{0.5, 0.25, 0.125, 0.0625, 0.03125};
const std::vector<double> first_order_steps{1, 1.0 / 4, 1.0 / 16, 1.0 / 64, 1.0 / 256};

glm::dvec3 color_of(double value) { return {1 - 0.8 * value, 0.4, 0.2 + 0.8 * value}; }

/// Tents of half-width w about values.
TransferFunction tents(const std::vector<double>& values, double w) {
  std::vector<TransferPoint> points;
  for (const double middle : values)
    for (const int side : {-1, 0, 1}) {
      const double value = middle + side * w;
      points.push_back({value, side == 0 ? 1.0 : 0.0, color_of(value)});
    }
  return TransferFunction(std::move(points));
}

/// A function of the cube [-1, 1]^3, at `side` voxels along each edge, from face to face.
std::shared_ptr<const Field> cube(int side, const std::function<double(const glm::dvec3&)>& f) {
  const double size = 2.0 / (side - 1);
  const glm::dmat4 m = glm::scale(glm::translate(glm::dmat4(1), glm::dvec3(-1)), glm::dvec3(size));
  return share(make_field(
      {glm::ivec3(0), glm::ivec3(side - 1)},
      [&](glm::ivec3 v) { return float(f(size * glm::dvec3(v) - 1.0)); }, m));
}

struct Maker {
  bool full;
  std::filesystem::path folder;

  Scene scene(double K, int side = 64, int full_side = 256) const {
    return small_scene(full ? full_side : side, K);
  }

  View view(Scene scene, const std::string& name, const TransferFunction& function,
            std::shared_ptr<const Field> density) const {
    scene.transfer_function = (folder / (name + ".json")).string();
    write_text(scene.transfer_function, to_json(function));
    return make_view(scene, std::move(density), nullptr);
  }

  /// Looks at a field from one place of its index space to another.
  Scene across(const Field& field, double K, const glm::dvec3& from, const glm::dvec3& to) const {
    const auto world = [&](const glm::dvec3& p) {
      return glm::dvec3(field.world_from_index * glm::dvec4(p, 1));
    };
    Scene out = looking(scene(K), world(from), world(to));
    out.fov = 25;
    return out;
  }

  /// A plate of glowing values, L = value.
  SuiteScene plate(const std::string& name, const std::string& medium, const Field& plate, double K,
                   const glm::dvec3& from, const glm::dvec3& to) const {
    const View view = view_of(across(plate, K, from, to), plate, Glow::density);
    return {name, medium, Smoothness::kinks, {view}, value_rules, usual_steps};
  }

  /// The cube through tents, from 30 degrees above its middle, in several turns about z.
  SuiteScene shells(const std::string& name, const std::string& medium, double K, double w,
                    const std::shared_ptr<const Field>& field, int turns = 1, int side = 64,
                    int full_side = 256) const {
    const TransferFunction function = tents({0.3, 0.5, 0.7}, w);
    SuiteScene out{
        name,
        medium + ", through tents of half-width " + two_digits(w) + " about 0.3, 0.5 and 0.7",
        Smoothness::kinks,
        {},
        function_rules,
        fine_steps};
    out.tent = w;
    for (int turn = 0; turn < turns; ++turn) {
      const double yaw = glm::radians(17.0 + 36 * turn);
      const glm::dvec3 from(std::cos(yaw), std::sin(yaw), std::tan(glm::radians(30.0)));
      Scene scene = looking(this->scene(K, side, full_side), 4.0 * glm::normalize(from), {0, 0, 0});
      scene.camera_up = glm::dvec3(0, 0, 1);
      scene.clip = WorldBox{glm::dvec3(-1), glm::dvec3(1)};
      scene.fov = 45;
      out.views.push_back(view(scene, name, function, field));
    }
    return out;
  }
};

/// Marschner and Lobb's signal (An Evaluation of Reconstruction Filters for Volume Rendering, 1994,
/// eq. 1).
double marschner_lobb(const glm::dvec3& p) {
  constexpr double f_M = 6, alpha = 0.25, pi = std::numbers::pi;
  const double ripple = std::cos(2 * pi * f_M * std::cos(pi / 2 * std::hypot(p.x, p.y)));
  return (1 - std::sin(pi / 2 * p.z) + alpha * (1 + ripple)) / (2 * (1 + alpha));
}

/// A field that varies only along x, by `count` values from x = 0 on.
Field plate_of(int count, const std::function<double(int x)>& value,
               const glm::dmat4& m = glm::dmat4(1)) {
  return make_field(
      {{0, -30, -30}, {count - 1, 30, 30}}, [&](glm::ivec3 v) { return float(value(v.x)); }, m);
}

/// A Gaussian along x.
Field bell() {
  return plate_of(33, [](int x) { return std::exp(-std::pow((x - 16) / 6.0, 2)); });
}

/// Values that attenuate and glow.
void add_values(std::vector<SuiteScene>& all, const Maker& make) {
  all.push_back(make.plate("gaussian", "e^(-x²/36) across 33 voxels, K 0.3, L = value", bell(), 0.3,
                           {-40, 6, 9}, {16, 0, 0}));
  all.push_back(make.plate("inside", "the same Gaussian, with the camera in its middle", bell(),
                           0.3, {14.3, 0.2, 0.4}, {30, 3, 2}));
  all.back().smoothness = Smoothness::cut;
  all.back().steps = first_order_steps;
  const Field ramp = plate_of(56, [](int x) { return 0.125 * std::min(x + 1, 32); });
  all.push_back(make.plate("ramp", "a value that rises by 1/8 a voxel, K 0.5, L = value", ramp, 0.5,
                           {-20, 2, 3}, {4, 0, 0}));
  const Field turned = plate_of(
      33, [](int x) { return 0.125 * std::min(x, 12); }, sheared);
  all.push_back(make.plate("rotated",
                           "a ramp and a plateau, rotated, sheared, in voxels of 0.3 x 0.5 x 1.1",
                           turned, 0.3, {-30, 3, 2}, {16, 0, 0}));
  const glm::ivec3 at(8, 0, -8);
  const View voxel = view_of(looking(make.scene(2), {20, 9, -1}, glm::dvec3(at), 3.0),
                             make_field({at, at}, [](glm::ivec3) { return 1.0f; }), Glow::density);
  all.push_back({"voxel",
                 "one voxel of value 1 in vacuum, K 2, L = value",
                 Smoothness::kinks,
                 {voxel},
                 value_rules,
                 fine_steps});
  const Spheres both = thesis_spheres();
  const Scene along = looking(make.scene(0.12), {15.5, 15.5, 200}, {15.5, 15.5, 28}, 32.0);
  all.push_back({"spheres",
                 "Moreland's two spheres, red in front of blue, seen along an axis; K 0.12",
                 Smoothness::kinks,
                 {view_of(along, both.density, both.color)},
                 {porter_duff, Integrator::average, Integrator::linear_luminance,
                  Integrator::opacity_linear, Integrator::psi_weighted, Integrator::psi_balanced},
                 {12, 6, 3, 1.5, 0.75, 0.375}});
}

/// Values that attenuate and glow through a function.
void add_functions(std::vector<SuiteScene>& all, const Maker& make) {
  const int side = make.full ? 128 : 64;
  all.push_back(make.shells("sphere", "1 - r in the cube [-1, 1]³", 15, 0.05,
                            cube(side, [](const glm::dvec3& p) { return 1 - glm::length(p); })));
  const auto tube = cube(side, [](const glm::dvec3& p) {
    return 10 * (0.1 - std::hypot(p.y, p.z) * std::pow(0.9 - 0.5 * std::cos(7 * p.x), 3));
  });
  all.push_back(make.shells("tube", "a tube of varying width in the same cube", 15, 0.05, tube));
  all.back().smoothness = Smoothness::cut;  // by the cube's faces
  const double level = 0.6, opacity = 0.4;
  const TransferFunction step(
      {{level, 0, color_of(level)}, {level, 1, color_of(level)}, {1, 1, color_of(1)}});
  SuiteScene stepped = make.plate("step", "the Gaussian, vacuum below 0.6, K 0.4 above", bell(),
                                  opacity, {-40, 6, 9}, {16, 0, 0});
  Scene across = make.across(bell(), opacity, {-40, 6, 9}, {16, 0, 0});
  stepped.views = {make.view(across, "step", step, share(bell()))};
  stepped.smoothness = Smoothness::jumps;
  stepped.rules = function_rules;
  stepped.steps = first_order_steps;
  all.push_back(stepped);
  const auto blob = [&](double K) {
    return looking(make.scene(K), {80, 66, 70}, {19.5, 17.5, 15.5}, 44.0);
  };
  all.push_back({"opaque",
                 "blobs with silhouettes, vacuum below 0.6, K 4 above",
                 Smoothness::rough,
                 {make.view(blob(4), "opaque", step, share(blobs()))},
                 function_rules,
                 first_order_steps});
  all.back().touches_jump = true;
  const TransferFunction two_d({{0, 0, color_of(0)}, {1, 0, color_of(1)}}, true,
                               {.isosurfaces = {{0.3, 1.5, 0.5}, {0.7, 1, 1}}});
  all.push_back({"gradient",
                 "the same blobs, with two of Levoy's surfaces: a function of value and gradient",
                 Smoothness::kinks,
                 {make.view(blob(1), "gradient", two_d, share(blobs()))},
                 value_rules,
                 fine_steps});
}

}  // namespace

Spheres thesis_spheres() {
  const auto sphere = [](const glm::dvec3& p, const glm::dvec3& c) {
    const glm::dvec3 d = (p - c) / 12.0;
    return std::max(0.0, 1 - glm::dot(d, d));
  };
  const Box box{{0, 0, 0}, {31, 31, 55}};
  return {make_field(box,
                     [&](glm::ivec3 v) {
                       const glm::dvec3 p(v);
                       return float(sphere(p, {17, 17, 40}) + sphere(p, {14, 14, 16}));
                     }),
          make_vector_field(box, [](glm::ivec3 v) {
            const float red = float(std::clamp((v.z - 22) / 12.0, 0.0, 1.0));
            return glm::vec3(0.05f + 0.95f * red, 0.15f, 1.0f - 0.95f * red);
          })};
}

std::vector<SuiteScene> suite_scenes(bool full, const std::filesystem::path& folder) {
  const Maker make{full, folder};
  std::vector<SuiteScene> all;
  add_values(all, make);
  add_functions(all, make);
  const auto signal = cube(128, marschner_lobb);
  const double widest = std::pow(0.05, 0.1), thinnest = std::pow(0.002, 0.1);
  for (int i = 0; i < 10; i += full ? 1 : 9) {
    const double w = std::pow(std::lerp(widest, thinnest, i / 9.0), 10);
    all.push_back(make.shells("marschner-lobb-" + formatted("%.4f", w),
                              "Marschner and Lobb's signal in 128³ voxels, f_M 6, alpha 0.25",
                              20 * 0.05 / w, w, signal, full ? 10 : 1, 48, 512));
    all.back().smoothness = Smoothness::rough;
    all.back().steps = full ? std::vector{0.1, 0.01, 0.001} : std::vector{0.1, 0.01};
  }
  return all;
}

double expected_order(const SuiteScene& scene, const Method& method) {
  const bool cells = method.sampling == Sampling::cells;
  if (is_cell_rule(method.integrator) || scene.smoothness == Smoothness::rough) return 0;
  // A plate's jump is at the same place of a cell on every ray.
  if (cells && scene.smoothness == Smoothness::jumps) return 0;
  // Values that are linear along a segment meet a jump where it is, to second order.
  if (is_transfer_rule(method.integrator)) return 2;
  if (scene.smoothness == Smoothness::jumps) return 1;
  // A sum of front samples is a sum of middle samples on a shifted lattice, unless the lattice has
  // ends in the medium: the camera's, or each cell's.
  if (method.integrator == porter_duff && (cells || scene.smoothness == Smoothness::cut)) return 1;
  return 2;
}

}  // namespace psivox
