#include "march_choice.h"

#include <cstdio>
#include <glm/common.hpp>

namespace psivox {
namespace {

/// Time of a ray [ms] by the way that budgets are counted in, from a small picture.
double unit_ms(const View& view, const MediumAtlas& atlas, GlRenderer* gpu) {
  View small = budget_unit(view);
  small.scene.resolution = glm::max(view.scene.resolution / 4, glm::ivec2(1));
  small.scene.pixel_samples = 1;
  const RenderStats stats = (gpu ? gpu->render(small) : render_march_double(small, atlas)).stats;
  return stats.march_ms / double(stats.rays);
}

}  // namespace

View choose_march(const View& view, const MediumAtlas& atlas, std::optional<double> time_budget,
                  GlRenderer* gpu, bool quiet, RenderReport& report) {
  if (!view.scene.tolerance && !time_budget) return view;
  const Stopwatch planning;
  report.tolerance = view.scene.tolerance;
  if (time_budget) {
    const double rays = double(view.scene.resolution.x) * double(view.scene.resolution.y) *
                        view.scene.pixel_samples;
    report.plan = plan_within(view, atlas, *time_budget / (rays * unit_ms(view, atlas, gpu)));
    if (!report.plan->reached && !quiet)
      std::fprintf(stderr,
                   "psivox: no march is expected to end within %.4g ms; marched as coarsely as is "
                   "reasonable\n",
                   *time_budget);
  } else {
    report.plan = plan_march(view, atlas);
    if (!report.plan->reached && !quiet)
      std::fprintf(stderr,
                   "psivox: the error is estimated as %.2g, above --tolerance %.2g; marched as "
                   "exactly as it can be\n",
                   report.plan->chosen.rms, *view.scene.tolerance);
  }
  report.plan_ms = planning.ms();
  return report.plan->view;
}

void confirm_plan(GlRenderer& gpu, RenderOptions options, bool quiet, RenderReport& report) {
  if (report.plan->rays() == 0) return;
  options.progress = {};
  const double expected = report.plan->chosen.rms;
  confirm(*report.plan, gpu.render(pilot_view(report.plan->view), options).image);
  const double rms = report.plan->chosen.rms;
  if (!report.tolerance || rms <= *report.tolerance) return;
  report.plan->reached = false;
  if (expected <= *report.tolerance && !quiet)
    std::fprintf(stderr,
                 "psivox: the error is %.2g, above --tolerance %.2g, by the device's arithmetic\n",
                 rms, *report.tolerance);
}

}  // namespace psivox
