#include <gtest/gtest.h>

#include "march_cases.h"

namespace psivox {
namespace {
double depth_difference(const Image& a, const Image& b, int* mismatch) {
  double most = 0;
  const auto &x = layer(a, "depth").values, &y = layer(b, "depth").values;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (std::isinf(x[i]) != std::isinf(y[i])) {
      ++*mismatch;
      continue;
    }
    if (!std::isinf(x[i])) most = std::max<double>(most, std::abs(x[i] - y[i]));
  }
  return most;
}
TEST(X, Explore) {
  const Scene far = looking(small_scene(32), {60, 70, 90}, {10, 12, 11});
  const Scene ortho = looking(small_scene(32), {60, 70, 90}, {10, 12, 11}, 60);
  const Scene inside = looking(small_scene(32), {12.2, 11.1, 12.4}, {30, 14, 11});
  const auto tf = std::make_shared<const TransferFunction>(std::vector<TransferPoint>{
      {0, 0, {1, 0, 0}}, {0.5, 0, {1, 0.4, 0}}, {0.6, 1, {0, 0.3, 1}}, {2, 1, {0, 1, 0}}});
  int w = 0;
  for (const Scene& s : {far, ortho, inside}) {
    printf("--- scene %d\n", w++);
    for (int function : {0, 1})
      for (bool noisy : {false, true})
        for (Mode mode :
             {Mode::mip, Mode::lmip, Mode::xray, Mode::isosurface, Mode::back_to_front}) {
          View view = view_of(s, noisy ? mixed() : blobs());
          view.scene.mode = mode;
          view.scene.lmip_threshold = 0.45;
          view.medium.isovalue = 0.4;
          view.medium.extinction = 0.1;
          view.medium.color = {1, 0.5, 2};
          if (function) view.medium.transfer = tf, view.medium.source = LuminanceSource::transfer;
          Image ref = render_reference(view).image;
          std::string name = std::to_string(function) + (noisy ? " mixed" : " blobs") + " mode " +
                             std::to_string(int(mode));
          MediumAtlas atlas = build_medium_atlas(view);
          RenderOptions o;
          o.depth = true;
          Image d = render_double(view, atlas, o).image;
          Image g = render_gl(view, atlas, {.render = o}).image;
          difference(name + " double", d, ref);
          difference(name + " gl", g, ref);
          if (mode == Mode::mip || mode == Mode::lmip || mode == Mode::isosurface) {
            int a = 0, b = 0;
            double x = depth_difference(d, ref, &a), y = depth_difference(g, ref, &b);
            printf("      depth double %.2e (%d) gl %.2e (%d)  alpha %g\n", x, a, y, b,
                   mean_alpha(ref));
          }
        }
  }
}
}  // namespace
}  // namespace psivox
