// bench_tolerance [-r SIDE] SCENE.json ...: pictures asked for by their error, on scenes
// such as those of tools/bench/scenes. Of each scene and tolerance: what was chosen, the error that
// was achieved, and look-ups and processor time against the best uniform rule and step that give
// the tolerance, found by drawing them: halves of 8, then between the two that enclose the
// tolerance. Times are medians of rounds in which all take turns.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "median.h"
#include "psivox/error.h"
#include "psivox/error_control.h"
#include "psivox/parameters.h"
#include "psivox/renderer.h"
#include "psivox/statistics.h"
#include "psivox/text_file.h"

namespace {

using namespace psivox;
using bench::median;

constexpr double tolerances[] = {1e-2, 1e-3, 1e-4, 1e-5};
constexpr int rounds = 3;

struct Case {
  std::string name;
  Scene scene;
};

struct Drawn {
  Image image;
  double samples = 0;          ///< a ray
  std::vector<double> cpu_ms;  ///< of each round
};

Drawn draw(GlRenderer& gl, const View& view) {
  RenderResult counted = gl.render(view, {.count = true});
  return {std::move(counted.image), double(counted.stats.samples) / double(counted.stats.rays), {}};
}

/// What 99.9 % of the pixels are within, by their worst channels.
double tail_of(const Image& a, const Image& b) {
  std::vector<double> worst;
  for (std::size_t i = 0; i < a.rgba().size(); i += 4) {
    double most = 0;
    for (std::size_t c = 0; c < 4; ++c)
      most = std::max(most, std::abs(double(a.rgba()[i + c]) - double(b.rgba()[i + c])));
    worst.push_back(most);
  }
  return percentile(std::move(worst), 0.999);
}

/// One uniform rule at one step.
struct CurvePoint {
  View view;
  Drawn drawn;
  double rms = 0, tail = 0;  ///< tail: of 99.9 % of the pixels
  double step() const { return *view.scene.step; }
};

/// One uniform rule, from wide steps to narrow ones.
struct Curve {
  std::string name;
  std::vector<CurvePoint> points;
};

/// The first point that gives the error.
std::vector<CurvePoint>::iterator first_within(Curve& curve, double error) {
  return std::find_if(curve.points.begin(), curve.points.end(),
                      [&](const CurvePoint& p) { return p.rms <= error; });
}

/// What the rules take at least for an error and a tail: of the points that keep both, or more than
/// that of the narrowest step where none does.
struct Hindsight {
  double cost = 0;
  bool more = false;
};
template <typename Cost>
Hindsight hindsight(const std::vector<Curve>& curves, double error, double tail, Cost cost) {
  std::optional<double> best, narrowest;
  const auto take = [](std::optional<double>& to, double c) { to = to ? std::min(*to, c) : c; };
  for (const Curve& curve : curves) {
    take(narrowest, cost(curve.points.back().drawn));
    for (const CurvePoint& p : curve.points)
      if (p.rms <= error && p.tail <= tail) take(best, cost(p.drawn));
  }
  return {best.value_or(*narrowest), !best};
}

void run(const Case& c, int side) {
  Scene scene = c.scene;
  scene.resolution = {side, side};
  const View base = make_view(scene, VdbFile(scene.input));
  const MediumAtlas atlas = build_medium_atlas(base);
  GlRenderer gl;
  gl.upload(atlas);
  const auto variant = [&](auto change) {
    View view = base;
    view.scene.sampling.reset();
    view.scene.step.reset();
    change(view.scene);
    return view;
  };
  const View exact = exact_view(base);
  const Image truth = render_march_double(exact, atlas).image;

  std::vector<Curve> curves;
  for (const Integrator rule :
       {Integrator::psi_balanced, Integrator::midpoint, Integrator::porter_duff}) {
    const auto point = [&](double step) {
      const View view = variant([&](Scene& s) {
        s.step = step;
        s.integrator = rule;
      });
      Drawn drawn = draw(gl, view);
      const double rms = compare_images(drawn.image, truth).rms, tail = tail_of(drawn.image, truth);
      return CurvePoint{view, std::move(drawn), rms, tail};
    };
    Curve curve{info(rule).name, {}};
    for (double step = 8; step > 0.03; step /= 2) {
      curve.points.push_back(point(step));
      if (curve.points.back().rms < 5e-6) break;
    }
    // The error need not grow with the step: the widest step is found by drawing.
    for (const double tolerance : tolerances)
      for (int i = 0; i < 3; ++i) {
        const auto fine = first_within(curve, tolerance);
        if (fine == curve.points.begin() || fine == curve.points.end()) break;
        const auto coarse = fine - 1;
        const double part = std::log(fine->rms / tolerance) / std::log(fine->rms / coarse->rms);
        if (part < 0.05) break;
        const double step = fine->step() * std::pow(coarse->step() / fine->step(), 0.97 * part);
        curve.points.insert(fine, point(step));
      }
    curves.push_back(std::move(curve));
  }
  struct Asked {
    double tolerance;
    MarchPlan plan;
    double plan_ms;
    Drawn drawn;
  };
  std::vector<Asked> asked;
  for (const double tolerance : tolerances) {
    const std::clock_t before = std::clock();
    View view = base;
    view.scene.tolerance = tolerance;
    view.scene.early_termination.reset();
    MarchPlan plan = plan_march(view, atlas);
    const double ms = 1e3 * double(std::clock() - before) / CLOCKS_PER_SEC;
    Drawn drawn = draw(gl, plan.view);
    if (plan.rays() > 0) confirm(plan, gl.render(pilot_view(plan.view)).image);
    asked.push_back({tolerance, std::move(plan), ms, std::move(drawn)});
  }
  Drawn exact_drawn = draw(gl, exact);
  for (int i = 0; i < rounds; ++i) {
    const auto time = [&](const View& view, Drawn& drawn) {
      drawn.cpu_ms.push_back(gl.render(view).stats.cpu_ms);
    };
    for (Curve& curve : curves)
      for (CurvePoint& p : curve.points) time(p.view, p.drawn);
    for (Asked& a : asked) time(a.plan.view, a.drawn);
    time(exact, exact_drawn);
  }
  std::printf("%s: extinction %.3g, cell-exact %.1f look-ups, %.0f ms\n", c.name.c_str(),
              base.medium.extinction, exact_drawn.samples, median(exact_drawn.cpu_ms));
  for (const Curve& curve : curves) {
    std::printf("  %-14s", curve.name.c_str());
    for (const CurvePoint& p : curve.points)
      std::printf(" %.3g: %.1e/%.1f/%.0f", p.step(), p.rms, p.drawn.samples,
                  median(p.drawn.cpu_ms));
    std::printf("\n");
  }
  for (const Asked& a : asked) {
    const Comparison error = compare_images(a.drawn.image, truth);
    const auto ms_of = [](const Drawn& d) { return median(d.cpu_ms); };
    const auto samples_of = [](const Drawn& d) { return d.samples; };
    const double tail = tail_of(a.drawn.image, truth), ms = ms_of(a.drawn);
    const double kept_tail = std::max(tail, 5 * a.tolerance);
    const auto ratio = [](const Hindsight& h, double own) {
      char text[32];
      std::snprintf(text, sizeof text, "%s%.2f", h.more ? ">" : "", h.cost / own);
      return std::string(text);
    };
    const auto ratios = [&](double most_tail) {
      return ratio(hindsight(curves, a.tolerance, most_tail, samples_of), a.drawn.samples) + " " +
             ratio(hindsight(curves, a.tolerance, most_tail, ms_of), ms);
    };
    std::printf(
        "  E %.0e  %-34s%s rms/E %.3f (est %.3f) p99.9/E %.1f max/E %.1f  look-ups %.1f ms %.0f "
        "hindsight over these %s, with this tail %s  plan %.0f ms (%d rays, %zu trials)\n",
        a.tolerance, trial_text(a.plan.chosen).c_str(), a.plan.view.brick_steps ? "*" : " ",
        error.rms / a.tolerance, a.plan.chosen.rms / a.tolerance, tail / a.tolerance,
        error.max / a.tolerance, a.drawn.samples, ms, ratios(1e30).c_str(),
        ratios(kept_tail).c_str(), a.plan_ms, a.plan.rays(), a.plan.trials.size());
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    int side = 256;
    for (int i = 1; i < argc; ++i) {
      if (std::string(argv[i]) == "-r") {
        side = std::atoi(argv[++i]);
        continue;
      }
      run({std::filesystem::path(argv[i]).stem().string(),
           scene_from_json(read_text(argv[i], "scene"))},
          side);
    }
    return 0;
  } catch (const Error& e) {
    std::fprintf(stderr, "bench_tolerance: %s\n", e.what());
    return int(e.code());
  }
}
