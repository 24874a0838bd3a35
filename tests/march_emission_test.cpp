#include <gtest/gtest.h>

#include "march_cases.h"

namespace psivox {
namespace {
Field glow_at(const glm::ivec3& at, const glm::dmat4& m = glm::dmat4(1)) {
  return make_field(
      {at, at + glm::ivec3(29, 25, 21)},
      [at](glm::ivec3 v) { return 0.05f * blobs_at(glm::dvec3(v - at)); }, m);
}
TEST(X, Explore) {
  const Scene scene = looking(small_scene(32), {60, 70, 90}, {10, 12, 11});
  const auto shifted = glm::translate(
      glm::rotate(glm::scale(glm::dmat4(1), glm::dvec3(0.9)), 0.5, glm::dvec3(1, 2, 3)),
      glm::dvec3(-4, 5, 3));
  for (int place : {0, 1, 2}) {
    Field e = place == 0   ? glow_at({0, 0, 0})
              : place == 1 ? glow_at({30, 20, 16})
                           : glow_at({0, 0, 0}, shifted);
    for (auto src :
         {LuminanceSource::constant, LuminanceSource::density, LuminanceSource::scalar}) {
      View view = src == LuminanceSource::scalar
                      ? view_of(scene, blobs(), mixed())
                      : view_of(scene, blobs(),
                                src == LuminanceSource::density ? Glow::density : Glow::constant);
      view.medium.extinction = 0.3;
      view.medium.emission = share(e);
      view.medium.emission_scale = 1.5;
      Image ref = render_reference(view).image;
      printf("place %d source %d alpha %g\n", place, int(src), mean_alpha(ref));
      auto both = [&](std::string name, View v) {
        difference(name + " double", double_picture(v), ref);
        difference(name + " gl", gl_picture(v), ref);
      };
      for (int n : {1, 2, 4}) {
        View v = view;
        v.scene.segments = n;
        both("psi-weighted " + std::to_string(n), v);
      }
      View v = view;
      v.scene.integrator = Integrator::cell_exact;
      both("cell-exact", v);
      for (double h : {1.0, 0.5, 0.25}) {
        v.scene.integrator = Integrator::psi_balanced;
        v.scene.sampling = Sampling::uniform;
        v.scene.step = h;
        both("balanced uniform" + std::to_string(h), v);
      }
    }
  }
  // function with attenuation(0) > 0
  View view = view_of(scene, blobs());
  view.medium.extinction = 0.1;
  view.medium.transfer = std::make_shared<const TransferFunction>(
      std::vector<TransferPoint>{{0, 0.1, {1, 0, 0}}, {1, 1, {0, 1, 0}}});
  view.medium.source = LuminanceSource::transfer;
  for (int place : {-1, 0, 1, 2}) {
    if (place >= 0)
      view.medium.emission = share(place == 0   ? glow_at({0, 0, 0})
                                   : place == 1 ? glow_at({30, 20, 16})
                                                : glow_at({0, 0, 0}, shifted));
    Image ref = render_reference(view).image;
    View v = view;
    v.scene.integrator = Integrator::cell_exact;
    difference("zero attenuates cell-exact double " + std::to_string(place), double_picture(v),
               ref);
    difference("zero attenuates cell-exact gl " + std::to_string(place), gl_picture(v), ref);
    v = view;
    v.scene.segments = 4;
    difference("zero attenuates psi-weighted double " + std::to_string(place), double_picture(v),
               ref);
    v.scene.integrator = Integrator::psi_balanced;
    v.scene.sampling = Sampling::uniform;
    v.scene.step = 0.5;
    difference("zero attenuates uniform double " + std::to_string(place), double_picture(v), ref);
  }
}
}  // namespace
}  // namespace psivox
