#include "study/suite.h"

#include <algorithm>
#include <map>

#include "base/text.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/study.h"
#include "study/page.h"

namespace psivox {
namespace {

/// Pictures of one size and their layers, one below the other.
Image stacked(const std::vector<Image>& pictures) {
  Image all = pictures.front();
  for (std::size_t i = 1; i < pictures.size(); ++i) {
    all.height += pictures[i].height;
    for (std::size_t l = 0; l < all.layers.size(); ++l)
      all.layers[l].values.insert(all.layers[l].values.end(), pictures[i].layers[l].values.begin(),
                                  pictures[i].layers[l].values.end());
  }
  return all;
}

class SuiteRun {
 public:
  SuiteRun(SuiteScene scene, Marcher& gpu) : gpu_(gpu) {
    for (View view : scene.views) {
      view.scene = studied_scene(view.scene);
      sessions_.emplace_back(std::move(view));
    }
    Sweep uniform, cells;
    uniform.samplings = {Sampling::uniform};
    uniform.integrators = scene.rules;
    uniform.steps = scene.steps;
    cells.samplings = {Sampling::cells};
    cells.integrators = {Integrator::psi_weighted, Integrator::cell_exact};
    cells.segments = {2, 4, 8};
    for (const Sweep& sweep : {uniform, cells})
      std::ranges::copy(plan_study(sweep, sessions_.front().view().scene).variants,
                        std::back_inserter(variants));
    result.scene = std::move(scene);
  }

  void take_reference(const std::filesystem::path& png) {
    write_image(draw_reference(1).front(), png);
    const auto& bounds = references_[1].layers.back().values;
    result.reference_bound = *std::max_element(bounds.begin(), bounds.end());
  }

  void measure(const Variant& variant) {
    SuiteRow row;
    StudyPoint& point = row.point;
    point.variant = variant;
    std::vector<Image> pictures;
    std::uint64_t rays = 0, samples = 0, steps = 0;
    double ms = 0;
    for (Session& session : sessions_) {
      Wish wish;
      wish.scene = scene_of(variant, session.view().scene);
      wish.confirm = false;
      wish.count = true;
      if (pictures.empty()) {  // a driver builds a program when it first draws with it
        wish.resolution = glm::ivec2(4);
        session.draw(gpu_, wish);
      }
      wish.resolution = session.view().scene.resolution / part(variant);
      Drawn drawn = session.draw(gpu_, wish);
      const RenderStats& counts = drawn.stats;
      rays += counts.rays, samples += counts.samples, steps += counts.steps;
      ms += counts.cpu_ms;
      result.faults += counts.stuck;
      pictures.push_back(std::move(drawn.image));
    }
    const Image picture = stacked(pictures);
    if (!references_.contains(part(variant))) draw_reference(part(variant));
    const Image& reference = references_[part(variant)];
    row.rays = rays;
    point.error = picture_error(picture, reference);
    point.samples_per_ray = double(samples) / double(rays);
    point.steps_per_ray = double(steps) / double(rays);
    point.times = {{ms, 0, ms}};
    result.faults += point.error.not_finite();
    std::vector<double> differences;
    for (std::size_t i = 0; i < picture.rgba().size(); ++i)
      differences.push_back(std::abs(double(picture.rgba()[i]) - reference.rgba()[i]));
    for (int bin = 0; bin < suite_bins; ++bin)
      row.above[std::size_t(bin)] =
          double(std::count_if(differences.begin(), differences.end(),
                               [=](double d) { return !(d <= std::pow(10, -1 - bin)); })) /
          double(differences.size());
    row.max = std::max(point.error.radiance.max, point.error.alpha.max);
    row.p999 = percentile(std::move(differences), 0.999);
    result.rows.push_back(std::move(row));
  }

  void fit_orders() {
    // Rounding adds its square to the error's: at 4 times it, 3 %.
    const double floor = 4 * rounding_rms(references_[1]);
    for (const SuiteRow& row : result.rows) {
      const Method& method = row.point.variant.method;
      if (is_cell_rule(method.integrator)) continue;
      const std::string way = variant_name(refinement(row.point.variant));
      if (result.orders.empty() || result.orders.back().way != way)
        result.orders.push_back({.scene = result.scene.name,
                                 .way = way,
                                 .expected = expected_order(result.scene, method),
                                 .floor = floor});
      result.orders.back().errors.emplace_back(
          method.step > 0 ? method.step : 1.0 / method.segments, row.point.rms());
    }
  }

  void forget() { sessions_.clear(), references_.clear(); }
  /// The work of a variant's picture [look-ups], as if rays crossed 100 voxels.
  double work(const Variant& v) const { return rays() * of_ray(v) / std::pow(part(v), 2); }
  /// The work of the reference [look-ups of the march by a software driver].
  double reference_work() const { return 3000 * rays(); }

  SuiteResult result;
  std::vector<Variant> variants;

 private:
  double rays() const {
    double sum = 0;
    for (const Session& session : sessions_) {
      const glm::dvec2 size(session.view().scene.resolution);
      sum += size.x * size.y;
    }
    return sum;
  }

  static double of_ray(const Variant& v) {
    return 20 + (v.method.step > 0 ? 100 / v.method.step : 100.0 + 20 * v.method.segments);
  }
  /// Pictures of more look-ups have a half, a quarter, ... of the pixels on a side. An RMS does not
  /// need more: over the 40,000 pixels that are left of ten pictures of 512x512 it is known to 2 %.
  int part(const Variant& v) const {
    constexpr double most_look_ups = 4.5e9;
    int part = 1;
    while (rays() * of_ray(v) > most_look_ups * part * part) part *= 2;
    return part;
  }

  /// The reference's pictures, of a part of the pixels on a side.
  std::vector<Image> draw_reference(int part) {
    const auto reference = open_reference();
    std::vector<Image> pictures;
    for (Session& session : sessions_) {
      Wish wish;
      wish.layers.error = true;
      wish.resolution = session.view().scene.resolution / part;
      pictures.push_back(session.draw(*reference, wish).image);
    }
    references_[part] = stacked(pictures);
    return pictures;
  }

  Marcher& gpu_;
  std::vector<Session> sessions_;
  std::map<int, Image> references_;  ///< stacked, by their parts
};

}  // namespace

ExactBound exact_bound(const SuiteScene& scene) {
  const double of_value = scene.tent > 0 ? 2 * 0.37 * 0x1p-24 / scene.tent : 0;
  return {2e-6 + of_value,
          scene.touches_jump ? std::numeric_limits<double>::infinity() : 5e-5 + 8 * of_value};
}

std::string OrderRow::miss() const {
  return scene + ": " + way + " has order " + decimals(observed(), 2) + ", expected " +
         number_text(expected);
}

std::vector<std::string> SuiteResult::misses() const {
  std::vector<std::string> out;
  const auto miss = [&](const std::string& what) { out.push_back(scene.name + ": " + what); };
  for (const OrderRow& order : orders)
    if (!order.holds()) out.push_back(order.miss());
  const ExactBound bound = exact_bound(scene);
  for (const SuiteRow& row : rows)
    if (is_cell_rule(row.point.variant.method.integrator) &&
        (row.point.rms() > bound.rms || row.max > bound.max))
      miss("cell-exact has RMS " + two_digits(row.point.rms()) + " and largest error " +
           two_digits(row.max) + ", bounds " + two_digits(bound.rms) + " and " +
           two_digits(bound.max));
  if (faults) miss(std::to_string(faults) + " values are not finite, or rays stood still");
  return out;
}

std::string run_suite(const std::filesystem::path& folder, bool full, int device,
                      const Progress& progress) {
  const WrittenFolder written = study_folder(folder, false);
  const auto gpu = open_gpu({.device = device});
  std::vector<SuiteRun> runs;
  double all = 0, done = 0;
  for (SuiteScene& scene : suite_scenes(full, folder)) {
    runs.emplace_back(std::move(scene), *gpu);
    const SuiteRun& run = runs.back();
    all += run.reference_work();
    for (const Variant& variant : run.variants) all += run.work(variant);
  }
  std::vector<SuiteResult> results;
  for (SuiteRun& run : runs) {
    const auto advance = [&](double work) {
      done += work;
      if (progress) progress(done / all);
    };
    run.take_reference(folder / (run.result.scene.name + ".png"));
    advance(run.reference_work());
    for (const Variant& variant : run.variants) {
      run.measure(variant);
      advance(run.work(variant));
    }
    run.fit_orders();
    run.forget();
    results.push_back(std::move(run.result));
  }
  return write_suite(results, description(*gpu), folder);
}

}  // namespace psivox
