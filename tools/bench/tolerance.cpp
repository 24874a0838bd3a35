// bench_tolerance [-r SIDE] SCENE.json ...: pictures asked for by their error, on scenes
// such as those of tools/bench/scenes. Of each scene and tolerance: what was chosen, the error that
// was achieved, and look-ups and processor time against the best uniform rule, whose step is the
// one that gives the tolerance, found between those that were drawn. Times are medians of rounds in
// which all take turns.
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
#include "psivox/study.h"
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

/// Error, look-ups, time of one uniform rule over its steps.
struct Curve {
  std::string name;
  std::vector<View> views;
  std::vector<Drawn> drawn;
  std::vector<double> rms;
};

/// A cost at an error, between the curve's points in the logarithms; unset: the curve does not get
/// there. Where its coarsest is accurate enough, that one's.
std::optional<double> cost_at(const Curve& curve, const std::vector<double>& cost, double error) {
  std::optional<double> best;
  const auto take = [&](double c) { best = best ? std::min(*best, c) : c; };
  for (std::size_t i = 0; i < cost.size(); ++i) {
    if (curve.rms[i] <= error) take(cost[i]);
    if (i == 0) continue;
    const double a = curve.rms[i - 1], b = curve.rms[i];
    if (b <= error && error < a)
      take(cost[i - 1] * std::pow(cost[i] / cost[i - 1], std::log(a / error) / std::log(a / b)));
  }
  return best;
}

double p999(const Image& a, const Image& b) {
  std::vector<double> worst;
  for (std::size_t i = 0; i < a.rgba().size(); i += 4) {
    double most = 0;
    for (std::size_t c = 0; c < 4; ++c)
      most = std::max(most, std::abs(double(a.rgba()[i + c]) - double(b.rgba()[i + c])));
    worst.push_back(most);
  }
  return percentile(std::move(worst), 0.999);
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
    Curve curve{info(rule).name, {}, {}, {}};
    for (double step = 8; step > 0.1; step /= 2) {
      curve.views.push_back(variant([&](Scene& s) {
        s.step = step;
        s.integrator = rule;
      }));
      curve.drawn.push_back(draw(gl, curve.views.back()));
      curve.rms.push_back(compare_images(curve.drawn.back().image, truth).rms);
      if (curve.rms.back() < 5e-6) break;
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
    asked.push_back({tolerance, std::move(plan), ms, std::move(drawn)});
  }
  Drawn exact_drawn = draw(gl, exact);
  for (int i = 0; i < rounds; ++i) {
    const auto time = [&](const View& view, Drawn& drawn) {
      drawn.cpu_ms.push_back(gl.render(view).stats.cpu_ms);
    };
    for (Curve& curve : curves)
      for (std::size_t k = 0; k < curve.views.size(); ++k) time(curve.views[k], curve.drawn[k]);
    for (Asked& a : asked) time(a.plan.view, a.drawn);
    time(exact, exact_drawn);
  }
  std::printf("%s: extinction %.3g, cell-exact %.1f look-ups, %.0f ms\n", c.name.c_str(),
              base.medium.extinction, exact_drawn.samples, median(exact_drawn.cpu_ms));
  for (const Curve& curve : curves) {
    std::printf("  %-14s", curve.name.c_str());
    for (std::size_t k = 0; k < curve.rms.size(); ++k)
      std::printf(" %.3g: %.1e/%.1f/%.0f", *curve.views[k].scene.step, curve.rms[k],
                  curve.drawn[k].samples, median(curve.drawn[k].cpu_ms));
    std::printf("\n");
  }
  for (const Asked& a : asked) {
    const Comparison error = compare_images(a.drawn.image, truth);
    std::optional<double> look_ups, time;
    for (const Curve& curve : curves) {
      std::vector<double> samples, ms;
      for (const Drawn& d : curve.drawn) {
        samples.push_back(d.samples);
        ms.push_back(median(d.cpu_ms));
      }
      if (const auto s = cost_at(curve, samples, a.tolerance))
        look_ups = std::min(look_ups.value_or(*s), *s);
      if (const auto t = cost_at(curve, ms, a.tolerance)) time = std::min(time.value_or(*t), *t);
    }
    const double ms = median(a.drawn.cpu_ms);
    std::printf(
        "  E %.0e  %-34s%s rms/E %.3f (est %.3f) p99.9/E %.1f max/E %.1f  look-ups %.1f ratio %.2f "
        " "
        "ms %.0f ratio %.2f plan %.0f ms (%d rays, %zu trials)\n",
        a.tolerance, trial_text(a.plan.chosen).c_str(), a.plan.view.brick_steps ? "*" : " ",
        error.rms / a.tolerance, a.plan.chosen.rms / a.tolerance,
        p999(a.drawn.image, truth) / a.tolerance, error.max / a.tolerance, a.drawn.samples,
        look_ups ? *look_ups / a.drawn.samples : 99.0, ms, time ? *time / ms : 99.0, a.plan_ms,
        a.plan.rays, a.plan.trials.size());
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
