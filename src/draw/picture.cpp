#include "draw/picture.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/text.h"
#include "march/film.h"
#include "march/light.h"
#include "march/march_double.h"
#include "march/march_tables.h"
#include "march/preintegration.h"
#include "plan/budget.h"
#include "plan/plan.h"
#include "psivox/parameters.h"
#include "reference/reference.h"

namespace psivox {
namespace {

/// Why the error is above the tolerance although the march is not expected to miss it.
std::string cause(const View& view, bool of_light) {
  if (const std::string lost = why_lost(view); !lost.empty()) return ": " + lost;
  if (!of_light) return ", by the device's arithmetic";
  const bool sky = view.scene.sky || !view.scene.environment.empty();
  return ", by the light" +
         (sky ? "; a sky has at most " + std::to_string(most_sky_count) + " directions"
              : std::string());
}

/// How far the table of `preintegrated` is off its definition; empty if that is little.
std::string table_notice(const View& view) {
  if (view.scene.resolved_integrator() != Integrator::preintegrated || !view.medium.transfer)
    return {};
  const double bound = preintegration_of(view, false)->error_bound();
  if (bound <= default_tolerance) return {};
  return formatted(
      "the table of --integrator preintegrated is off by up to %.2g of a segment's radiance; "
      "shorter segments are closer, and cell-exact needs no table",
      bound);
}

/// The deep picture of a view whose light is computed, on the CPU, by exact cells, whatever its
/// method.
RenderResult deep_picture(const View& view, const MediumAtlas& atlas, const Progress& progress) {
  const double tolerance = view.scene.tolerance.value_or(default_tolerance);
  View exact = exact_view(view);
  exact.scene.early_termination =
      budget::deep_end * tolerance / std::max(1.0, brightest_ray(view.medium));
  const double of_light = view.medium.lit ? light_share(view.scene) : 0;
  const double rest = budget::beside(of_light, 1) - budget::deep_end;
  return render_deep(exact, atlas, rest * tolerance, progress);
}

}  // namespace

Picture::Picture(PartMarcher& marcher, const View& view, const Wish& wish,
                 std::optional<MarchPlan> plan)
    : marcher_(marcher), view_(view), wish_(wish), plan_(std::move(plan)) {
  if (plan_) expected_rms_ = plan_->chosen.rms;
}

bool Picture::confirms() const {
  return plan_ && plan_->rays > 0 && wish_.confirm && marcher_.marcher().rounds();
}

void Picture::march(const std::shared_ptr<const MediumAtlas>& grids) {
  RenderOptions options{.count = wish_.count || wish_.layers.steps || wish_.layers.samples,
                        .depth = wish_.layers.depth,
                        .transmittance = wish_.layers.transmittance,
                        .progress = of_stage(wish_.progress, Stage::marching),
                        .tile = wish_.tile,
                        .tile_ms = wish_.tile_ms,
                        .may_update_tables = wish_.may_update_tables};
  if (plan_) options.brick_steps = plan_->march->brick_steps;
  if (plan_) options.ray_cost = plan_->chosen.cost;
  if (confirms()) options.pilot = pilot_view(marched());
  if (grids && !wish_.layers.deep) marcher_.marcher().hold(grids, view_.scene.filter);
  RenderResult result = view_.scene.shows(Shows::plane) ? draw_slice(view_, options)
                        : wish_.layers.deep ? deep_picture(view_, *grids, options.progress)
                                            : marcher_.render(marched(), options);
  drawn_.image = std::move(result.image);
  pilot_ = std::move(result.pilot);
  drawn_.stats = std::move(result.stats);
  const bool tabled = marcher_.marcher().marches() && !wish_.may_update_tables;
  if (std::string off = tabled ? table_notice(marched()) : ""; !off.empty()) say(std::move(off));
  if (drawn_.stats.stuck > 0)
    say(std::to_string(drawn_.stats.stuck) +
        " rays stopped early, because the device's arithmetic no longer moved them: their pixels "
        "lack what lies further back; psivox verify checks the driver");
}

void Picture::confirm_plan() {
  if (!plan_) return;
  const std::optional<double>& tolerance = view_.scene.tolerance;
  if (confirms()) {
    const bool one_ray = view_.scene.pixel_samples == 1 && drawn_.image.pixels() > 0;
    confirm(*plan_, pilot_, one_ray ? &drawn_.image : nullptr);
  }
  const double rms = plan_->chosen.rms;
  if (!tolerance) return;
  const auto above = [&](double error) {
    const std::string found = formatted("%.2g", error), wanted = formatted("%.2g", *tolerance);
    return found + (found == wanted ? ", a little above --tolerance " : ", above --tolerance ") +
           wanted;
  };
  if (!plan_->reached)
    say("the error is estimated as " + above(expected_rms_) + "; marched as exactly as it can be");
  else if (rms > *tolerance)
    say("the error is " + above(rms) + cause(view_, plan_->light_rms > *tolerance));
  if (rms > *tolerance || drawn_.stats.stuck > 0) plan_->reached = false;
}

void Picture::add_error(const Medium& medium) {
  enter(wish_.progress, Stage::checking);
  View exact = exact_view(marched());
  exact.medium = medium;
  const Image better = marcher_
                           .render(exact, {.progress = of_stage(wish_.progress, Stage::checking),
                                           .tile_ms = wish_.tile_ms})
                           .image;
  const CheckedError left = exact_error(exact, marcher_.render(pilot_view(exact)).image);
  const Backdrop behind(view_);
  const ErrorSum errors = seen_errors(drawn_.image, better, behind);
  drawn_.difference = compare_images(drawn_.image, better);
  drawn_.difference->rms = std::hypot(errors.rms(), left.rms);
  drawn_.difference->max = errors.max + left.max;
  drawn_.image.layers.push_back(error_layer(drawn_.image, better, behind, left.rms));
}

void Picture::add_bound(const Medium& medium) {
  View dark = view_;
  dark.medium = medium;
  const Progress progress = of_stage(wish_.progress, Stage::checking);
  const View exact = lit(
      dark, [&](std::size_t volume) { return reference_light_depths(dark, volume); }, progress);
  drawn_.image.layers.push_back(bound_layer(exact, drawn_.image, 1e-9, progress));
  drawn_.bound = *std::ranges::max_element(drawn_.image.layers.back().values);
}

void Picture::finish() {
  // Counting adds layers; keep only those asked for.
  std::erase_if(drawn_.image.layers, [&](const Layer& layer) {
    return !layer.name.empty() && !wish_.layers.has(layer.name);
  });
  drawn_.view = view_;
  drawn_.plan = std::move(plan_);
  const Scene& scene = view_.scene;
  if (!marcher_.marcher().marches() && scene.tolerance)
    say("--renderer reference ignores --tolerance");
  if (scene.shows(Shows::surface) && (scene.sky || !scene.environment.empty()))
    say(std::string(scene.sky ? "--sky does" : "--environment does") + " not light an isosurface" +
        (scene.given.contains("light") ? "" : "; --light X,Y,Z does"));
  const std::size_t regions = marcher_.split().own.count();
  if (!marcher_.whole() && marcher_.team().size() == 1)
    say("the volume is drawn in " + std::to_string(regions) + (regions == 1 ? " part" : " parts") +
        ", so that its atlas keeps within the memory");
}

void check_deep(const Scene& scene, const PartMarcher& parts) {
  if (const std::string obstacle = layer_obstacle("deep", scene); !obstacle.empty())
    throw Error(ExitCode::usage, obstacle);
  if (!parts.whole())
    throw Error(ExitCode::memory,
                "--aov deep needs the whole volume in one part; give a larger --memory-limit");
}

std::optional<glm::dvec3> pick_point(const View& view, const MediumAtlas& atlas,
                                     const glm::dvec2& pixel) {
  View one = view;
  one.scene.pixel_samples = 1;
  one.scene.mode = from_front(one.scene.mode);
  const glm::dvec2 corner = glm::floor(pixel);
  const Image image = render_march_double(one, atlas,
                                          {.depth = true,
                                           .place = pixel - corner,
                                           .pixels = PixelBox{glm::ivec2(corner), glm::ivec2(1)}})
                          .image;
  const double depth = image.layers.back().values.front();
  if (!std::isfinite(depth)) return {};
  const WorldRay ray = camera_ray(view.camera, view.scene.resolution, pixel.x, pixel.y);
  return ray.origin + depth * ray.direction;
}

}  // namespace psivox
