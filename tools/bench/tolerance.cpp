// bench_tolerance [-r SIDE] SCENE.json ...: measures pictures drawn to a tolerance, for example of
// the scenes in tools/bench/scenes. For each scene and tolerance it prints the method chosen, the
// error reached, and look-ups and CPU time relative to the best uniform rule and step that meets
// the tolerance. That step is found by drawing: it halves 8 repeatedly, then searches between the
// two steps that enclose the tolerance. Times are medians of rounds in which all pictures take
// turns.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/text.h"
#include "base/text_file.h"
#include "bench.h"
#include "psivox/draw.h"
#include "psivox/parameters.h"

namespace {

using namespace psivox;
using bench::median;

constexpr double tolerances[] = {1e-2, 1e-3, 1e-4, 1e-5};
constexpr int rounds = 3;

/// A picture by one method, and its cost.
struct Measured {
  Wish wish;
  Image image;
  double samples = 0;          ///< per ray
  std::vector<double> cpu_ms;  ///< one per round
};

Measured measure(Session& session, Marcher& gpu, Wish wish) {
  wish.count = true;
  Drawn counted = session.draw(gpu, wish);
  wish.count = wish.confirm = false;
  const RenderStats& stats = counted.stats;
  return {
      std::move(wish), std::move(counted.image), double(stats.samples) / double(stats.rays), {}};
}

/// The error that 99.9 % of the pixels stay within, by their worst channels.
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
  Measured drawn;
  double rms = 0, tail = 0;  ///< tail: error that 99.9 % of the pixels stay within
  double step() const { return *drawn.wish.scene->step; }
};

/// One uniform rule, from wide steps to narrow ones.
struct Curve {
  std::string name;
  std::vector<CurvePoint> points;
};

std::vector<CurvePoint>::iterator first_within(Curve& curve, double error) {
  return std::find_if(curve.points.begin(), curve.points.end(),
                      [&](const CurvePoint& p) { return p.rms <= error; });
}

/// Least cost of the rules for an error and a tail, over the points that meet both. If none does,
/// it is the cost of the narrowest step, and `more` is set.
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

/// A picture drawn to a tolerance.
struct Asked {
  double tolerance;
  MarchPlan plan;
  double plan_ms;
  Measured drawn;
};

/// All pictures of one scene.
class Scenario {
 public:
  Scenario(const std::string& path, int side)
      : name_(std::filesystem::path(path).stem().string()),
        scene_(scene_from_json(read_text(path, "scene"))) {
    scene_.resolution = {side, side};
    session_.emplace(make_view(scene_, VdbFile(scene_.input)));
    scene_ = session_->view().scene;
    scene_.sampling.reset();
    scene_.step.reset();
    truth_ = session_->draw(*open_double(), {.exact = true}).image;
  }

  void run() {
    for (const Integrator rule :
         {Integrator::psi_balanced, Integrator::midpoint, Integrator::porter_duff})
      curves_.push_back(curve_of(rule));
    for (const double tolerance : tolerances) asked_.push_back(ask(tolerance));
    Measured exact = measure(*session_, *gpu_, {.exact = true});
    const auto time = [&](Measured& drawn) {
      drawn.cpu_ms.push_back(session_->draw(*gpu_, drawn.wish).stats.cpu_ms);
    };
    for (int i = 0; i < rounds; ++i) {
      for (Curve& curve : curves_)
        for (CurvePoint& p : curve.points) time(p.drawn);
      for (Asked& a : asked_) time(a.drawn);
      time(exact);
    }
    print(exact);
  }

 private:
  CurvePoint point(Integrator rule, double step) {
    Wish wish;
    wish.scene = scene_;
    wish.scene->step = step;
    wish.scene->integrator = rule;
    Measured drawn = measure(*session_, *gpu_, wish);
    const double rms = compare_images(drawn.image, truth_).rms, tail = tail_of(drawn.image, truth_);
    return {std::move(drawn), rms, tail};
  }

  Curve curve_of(Integrator rule) {
    Curve curve{info(rule).name, {}};
    for (double step = 8; step > 0.03; step /= 2) {
      curve.points.push_back(point(rule, step));
      if (curve.points.back().rms < 5e-6) break;
    }
    // The error need not grow with the step, so the widest step is found by drawing.
    for (const double tolerance : tolerances)
      for (int i = 0; i < 3; ++i) {
        const auto fine = first_within(curve, tolerance);
        if (fine == curve.points.begin() || fine == curve.points.end()) break;
        const auto coarse = fine - 1;
        const double part = std::log(fine->rms / tolerance) / std::log(fine->rms / coarse->rms);
        if (part < 0.05) break;
        const double step = fine->step() * std::pow(coarse->step() / fine->step(), 0.97 * part);
        curve.points.insert(fine, point(rule, step));
      }
    return curve;
  }

  Asked ask(double tolerance) {
    Wish wish;
    wish.scene = scene_;
    wish.scene->integrator.reset();
    wish.scene->tolerance = tolerance;
    wish.scene->early_termination.reset();
    const Drawn drawn = session_->draw(*gpu_, wish);
    wish.plan = drawn.plan;
    return {tolerance, *drawn.plan, drawn.times.plan_cpu_ms, measure(*session_, *gpu_, wish)};
  }

  void print(const Measured& exact) const {
    std::printf("%s: extinction %.3g, cell-exact %.1f look-ups, %.0f ms\n", name_.c_str(),
                session_->view().medium.extinction, exact.samples, median(exact.cpu_ms));
    for (const Curve& curve : curves_) {
      std::printf("  %-14s", curve.name.c_str());
      for (const CurvePoint& p : curve.points)
        std::printf(" %.3g: %.1e/%.1f/%.0f", p.step(), p.rms, p.drawn.samples,
                    median(p.drawn.cpu_ms));
      std::printf("\n");
    }
    for (const Asked& a : asked_) print(a);
    std::fflush(stdout);
  }

  void print(const Asked& a) const {
    const Comparison error = compare_images(a.drawn.image, truth_);
    const auto ms_of = [](const Measured& d) { return median(d.cpu_ms); };
    const auto samples_of = [](const Measured& d) { return d.samples; };
    const double tail = tail_of(a.drawn.image, truth_), ms = ms_of(a.drawn);
    const double kept_tail = std::max(tail, 5 * a.tolerance);
    const auto ratio = [](const Hindsight& h, double own) {
      return formatted("%s%.2f", h.more ? ">" : "", h.cost / own);
    };
    const auto ratios = [&](double most_tail) {
      return ratio(hindsight(curves_, a.tolerance, most_tail, samples_of), a.drawn.samples) + " " +
             ratio(hindsight(curves_, a.tolerance, most_tail, ms_of), ms);
    };
    std::printf(
        "  E %.0e  %-34s%s rms/E %.3f (est %.3f) p99.9/E %.1f max/E %.1f  look-ups %.1f ms %.0f "
        "hindsight over these %s, with this tail %s  plan %.0f ms (%d rays, %zu trials)\n",
        a.tolerance, method_text(a.plan.chosen.method).c_str(), a.plan.by_brick ? "*" : " ",
        error.rms / a.tolerance, a.plan.chosen.rms / a.tolerance, tail / a.tolerance,
        error.max / a.tolerance, a.drawn.samples, ms, ratios(1e30).c_str(),
        ratios(kept_tail).c_str(), a.plan_ms, a.plan.rays, a.plan.trials.size());
  }

  std::string name_;
  Scene scene_;  ///< without a method
  std::shared_ptr<Marcher> gpu_ = open_gpu();
  std::optional<Session> session_;
  Image truth_;
  std::vector<Curve> curves_;
  std::vector<Asked> asked_;
};

}  // namespace

int main(int argc, char** argv) {
  return bench::run("bench_tolerance", [&] {
    int side = 256;
    for (int i = 1; i < argc; ++i)
      if (std::string(argv[i]) == "-r")
        side = std::atoi(argv[++i]);
      else
        Scenario(argv[i], side).run();
  });
}
