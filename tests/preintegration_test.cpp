// The table of `preintegrated`: compared with adaptive quadrature, its bound, its updates, the rule
// itself, and pictures of thin peaks.

#include "march/preintegration.h"

#include <random>

#include "march/atlas_march.h"
#include "march_cases.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

// --- by quadrature -------------------------------------------------------------------------------

/// Colour times attenuation, attenuation and radiance of a segment of linear values.
struct Direct {
  double depth = 0, opacity = 0;
  glm::dvec3 radiance{0}, thin{0};  ///< thin: mean luminance without self-attenuation
};

/// int_a^b of f, halved until Simpson's rule and its halves agree within `tolerance`.
template <typename F>
glm::dvec3 simpson(const F& f, double a, double b, double tolerance, int depth = 0) {
  const double m = 0.5 * (a + b);
  const auto rule = [&](double p, double q) {
    return (f(p) + f(0.5 * (p + q)) * 4.0 + f(q)) * ((q - p) / 6);
  };
  const glm::dvec3 whole = rule(a, b), halves = rule(a, m) + rule(m, b);
  const glm::dvec3 d = glm::abs(whole - halves);
  if (depth > 3 && (depth > 40 || std::max({d.x, d.y, d.z}) <= tolerance))
    return halves + (halves - whole) / 15.0;
  return simpson(f, a, m, 0.5 * tolerance, depth + 1) +
         simpson(f, m, b, 0.5 * tolerance, depth + 1);
}

/// Cut at the knots, each piece integrated separately. `length`: optical length at attenuation 1.
Direct direct(const TransferFunction& function, double front, double back, double length) {
  std::vector<double> cuts{0, 1};
  for (const TransferPoint& p : function.points()) {
    const double u = (p.value - front) / (back - front);
    if (u > 0 && u < 1) cuts.push_back(u);
  }
  std::sort(cuts.begin(), cuts.end());
  Direct sum;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double from = cuts[i], to = cuts[i + 1], x = (to - from) * length;
    if (!(to > from)) continue;
    // slightly inside, so that the two sides of a jump stay apart
    const auto inside = [&](double v) { return front + (back - front) * (from + (to - from) * v); };
    const TransferPoint a = function.at(inside(1e-12)), b = function.at(inside(1 - 1e-12));
    const auto tau = [&](double v) { return x * std::lerp(a.attenuation, b.attenuation, v); };
    const auto source = [&](double v) { return glm::mix(a.color, b.color, v) * tau(v); };
    const auto depth = [&](double v) { return 0.5 * v * (tau(0) + tau(v)); };
    sum.radiance +=
        simpson([&](double v) { return source(v) * std::exp(-depth(v)); }, 0.0, 1.0, 1e-12) *
        std::exp(-sum.depth);
    sum.thin += simpson(source, 0.0, 1.0, 1e-12 * (1 + x));
    sum.depth += depth(1);
  }
  sum.opacity = -std::expm1(-sum.depth);
  if (sum.depth > 0) sum.thin /= sum.depth;
  return sum;
}

// --- functions -----------------------------------------------------------------------------------

TransferFunction smooth() {
  return TransferFunction(
      {{0, 0, {0, 0, 1}}, {0.3, 0.2, {0, 1, 0}}, {0.7, 1, {1, 0.5, 0}}, {1, 0.4, {1, 1, 1}}});
}

/// Two tents of 1/20 of the range, red and blue.
TransferFunction peaked() {
  return TransferFunction({{0, 0, {1, 0, 0}},
                           {0.325, 0, {1, 0, 0}},
                           {0.35, 1, {1, 0, 0}},
                           {0.375, 0, {1, 0, 0}},
                           {0.625, 0, {0, 0, 1}},
                           {0.65, 1, {0, 0, 1}},
                           {0.675, 0, {0, 0, 1}},
                           {1, 0, {0, 0, 1}}});
}

TransferFunction jumps() {
  return TransferFunction({{0, 0.1, {0, 0, 1}},
                           {0.4, 0, {0, 0, 1}},
                           {0.4, 1, {1, 0, 0}},
                           {0.6, 1, {1, 0, 0}},
                           {0.6, 0.3, {0, 1, 0}},
                           {1, 0.3, {0, 1, 0}}});
}

TransferFunction random_function(int points, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(0, 1);
  std::vector<TransferPoint> p;
  for (int i = 0; i < points; ++i)
    p.push_back({i / (points - 1.0), u(random), {u(random), u(random), u(random)}});
  return TransferFunction(p);
}

const std::pair<const char*, TransferFunction> functions[] = {
    {"smooth", smooth()}, {"peaks", peaked()}, {"jumps", jumps()}, {"random", random_function(40)}};

double largest(const glm::dvec3& d) { return std::max({d.x, d.y, d.z}); }

/// Radiance of a segment by the table, with exact depth and thin limit.
glm::dvec3 radiance(const PreintegratedTable& table, const Direct& d, double front, double back,
                    double length) {
  const double mean = d.depth / (table.extinction() * length);
  return (d.thin + table.shading(front, back, length, mean)) * d.opacity;
}

// --- the table -----------------------------------------------------------------------------------

TEST(Preintegration, EntriesAreTheIntegral) {
  for (const auto& [name, function] : functions)
    for (const double extinction : {1e-6, 3.0, 2e4}) {
      const PreintegratedTable table(function, extinction, 1, {41, 2});
      std::mt19937 random(2);
      std::uniform_int_distribution<int> index(0, 40), layer(1, 2);
      double worst = 0;
      for (int n = 0; n < 60; ++n) {
        const double front = index(random) / 40.0, back = index(random) / 40.0;
        const double length = std::pow(layer(random) / 2.0, 2);
        if (front == back) continue;
        const Direct d = direct(function, front, back, extinction * length);
        worst = std::max(worst,
                         largest(glm::abs(radiance(table, d, front, back, length) - d.radiance)));
      }
      // Runs and entries are float32, 6e-8 each for luminances up to 1; the runs' opacities change
      // the weights of a whole span by as much. Quadrature cuts slightly beside jumps: 1e-7.
      EXPECT_LE(worst, 5e-7) << name << ", extinction " << extinction;
    }
}

TEST(Preintegration, ErrorBoundHolds) {
  for (const auto& [name, function] : functions)
    for (const double extinction : {0.1, 1.0, 10.0, 100.0})
      for (const int layers : {1, 4}) {
        const PreintegratedTable table(function, extinction, 1, {129, layers});
        const double bound = table.error_bound();
        std::mt19937 random(3);
        std::uniform_real_distribution<double> u(0, 1);
        double worst = 0;
        for (int n = 0; n < 60; ++n) {
          const double front = u(random);
          // half of them short, because the detail is there
          const double back =
              n % 2 ? u(random) : std::clamp(front + 0.1 * (u(random) - 0.5), 0.0, 1.0);
          const double length = n % 3 ? 1.0 : u(random);
          const Direct d = direct(function, front, back, extinction * length);
          worst = std::max(worst,
                           largest(glm::abs(radiance(table, d, front, back, length) - d.radiance)));
        }
        // the table's float32, as above
        EXPECT_LE(worst, bound + 5e-7) << name << ", extinction " << extinction;
        std::printf("  %-7s extinction %-5g %4d x %d: bound %.1e, seen %.1e\n", name, extinction,
                    table.size(), table.layers(), bound, worst);
      }
}

// --- the rule ------------------------------------------------------------------------------------

/// Waves of wavelength 12 voxels and more, from 0 to 1.
Field waves() {
  return make_field({{0, 0, 0}, {31, 31, 31}}, [](glm::ivec3 v) {
    const glm::dvec3 p = glm::dvec3(v) * 0.5;
    return float(0.5 + 0.5 * std::sin(p.x + 0.3 * p.z) * std::cos(0.7 * p.y - 0.2 * p.x + 0.4));
  });
}

View peaks_view(Integrator rule, const TransferFunction& function, double extinction,
                std::optional<double> step = {}, int side = 64) {
  Scene scene = small_scene(side);
  scene.step = step;
  scene.extinction = extinction;
  View view = view_of(looking(scene, {60, 45, 80}, {16, 16, 16}, 40), waves());
  view.medium.transfer = std::make_shared<const TransferFunction>(function);
  view.medium.source = LuminanceSource::transfer;
  view.scene.integrator = rule;
  return view;
}

TEST(PreintegrationRule, IsTheIntegralInsideAndOutsideOfTheKnots) {
  for (const auto& [name, function] : functions)
    for (const auto& [uniform, extinction] : {std::pair(false, 0.5), {true, 5.0}}) {
      const View view = peaks_view(Integrator::preintegrated, function, extinction,
                                   uniform ? std::optional(1.0) : std::nullopt);
      const MediumAtlas atlas = build_medium_atlas(view);
      const MarchSetup setup = make_march_setup(view, atlas);
      const double bound = setup.preintegration->error_bound();
      glsl::AtlasMarch march;
      march.tables = setup.tables.data();
      march.configure(setup);
      std::mt19937 random(4);
      std::uniform_real_distribution<double> u(0, 1);
      for (int n = 0; n < 60; ++n) {
        const double front = 2 * u(random) - 0.5, back = 2 * u(random) - 0.5;
        const double length = setup.preintegration->max_length() * (n % 2 ? 1 : u(random));
        const Direct d = direct(function, front, back, extinction * length);
        const auto mixture = march.preintegrated(front, back, length);
        // the function's table holds the integrals of knots in float32
        EXPECT_NEAR(mixture.depth, d.depth, 1e-6 * (extinction + d.depth))
            << name << " from " << front << " to " << back;
        EXPECT_LE(largest(glm::abs(mixture.L * d.opacity - d.radiance)), bound + 2e-6)
            << name << " from " << front << " to " << back;
      }
    }
}

TEST(PreintegrationRule, ConstantColourIsTheFurnace) {
  std::vector<TransferPoint> points = random_function(20).points();
  for (TransferPoint& p : points) p.color = glm::dvec3(1);
  const View view = peaks_view(Integrator::preintegrated, TransferFunction(points), 0.4);
  const Image image = double_picture(view);
  expect_content(image);
  const auto rgba = image.rgba();
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_NEAR(rgba[i + c], rgba[i + 3], 2e-6);  // float32 integrals of 20 knots, see above
}

TEST(PreintegrationRule, ThinPeaksAreSeenBetweenSamples) {
  // Two tents of a twentieth of the range, too narrow for two samples per cell.
  for (const double extinction : {0.3, 3.0, 30.0}) {
    const auto picture = [&](Integrator rule) {
      return double_picture(peaks_view(rule, peaked(), extinction));
    };
    const Image exact = picture(Integrator::cell_exact);
    expect_content(exact);
    const std::string what = ", extinction " + std::to_string(extinction);
    const double pre =
        difference("preintegrated" + what, picture(Integrator::preintegrated), exact).rms;
    const double fast =
        difference("preintegrated-fast" + what, picture(Integrator::preintegrated_fast), exact).rms;
    const double psi =
        difference("psi-weighted" + what, picture(Integrator::psi_weighted), exact).rms;
    EXPECT_LE(5 * pre, psi);
    EXPECT_LE(pre, 1.1 * fast);
  }
}

}  // namespace
}  // namespace psivox
