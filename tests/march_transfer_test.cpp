#include <gtest/gtest.h>

#include "march_cases.h"

namespace psivox {
namespace {

std::shared_ptr<const TransferFunction> function(std::vector<TransferPoint> points) {
  return std::make_shared<const TransferFunction>(std::move(points));
}

/// Two peaks and a plateau over the values of `mixed`.
const auto peaks = [] {
  return function({{0.1, 0, {1, 0.2, 0}},
                   {0.3, 0.6, {0.2, 1, 0}},
                   {0.4, 0.05, {0, 0.5, 1}},
                   {0.7, 0.1, {1, 1, 1}},
                   {1.2, 0.5, {1, 0, 0.5}}});
};
/// Vacuum below 0.35 and between 0.7 and 0.8.
const auto jumps = [] {
  return function({{0.35, 0, {0, 0, 1}},
                   {0.35, 0.4, {1, 0.5, 0}},
                   {0.7, 0.4, {0, 1, 1}},
                   {0.7, 0, {0, 1, 1}},
                   {0.8, 0, {1, 1, 0}},
                   {0.8, 0.3, {1, 1, 0}}});
};

TEST(X, Explore) {
  const Scene scene = looking(small_scene(24), {60, 70, 90}, {10, 12, 11});
  for (bool rough : {false, true})
    for (auto tf : {peaks(), jumps()})
      for (auto src :
           {LuminanceSource::constant, LuminanceSource::density, LuminanceSource::transfer}) {
        View view = view_of(scene, rough ? mixed() : blobs(),
                            src == LuminanceSource::density ? Glow::density : Glow::constant);
        view.medium.transfer = tf;
        view.medium.source = src;
        Image ref = render_reference(view).image;
        printf("source %d alpha %g\n", int(src), mean_alpha(ref));
        auto both = [&](std::string name, View v) {
          difference(name + " double", double_picture(v), ref);
          difference(name + " gl", gl_picture(v), ref);
        };
        for (int n : {1, 2, 4})
          for (bool split : {false, true}) {
            View v = view;
            v.scene.segments = n;
            v.scene.split_knots = split;
            both("psi-weighted " + std::to_string(n) + (split ? " split" : ""), v);
          }
        View v = view;
        v.scene.integrator = Integrator::cell_exact;
        both("cell-exact", v);
        for (int n : {1, 2}) {
          v.scene.integrator = Integrator::preintegrated_fast;
          v.scene.segments = n;
          both("preintegrated_fast " + std::to_string(n), v);
        }
        for (double h : {1.0, 0.5}) {
          v.scene.integrator = Integrator::psi_balanced;
          v.scene.sampling = Sampling::uniform;
          v.scene.step = h;
          both("balanced uniform" + std::to_string(h), v);
          v.scene.integrator = Integrator::preintegrated_fast;
          both("preint uniform" + std::to_string(h), v);
          v.scene.integrator = Integrator::midpoint;
          both("midpoint uniform" + std::to_string(h), v);
        }
      }
}

}  // namespace
}  // namespace psivox
