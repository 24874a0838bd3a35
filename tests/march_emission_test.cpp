// Emission grids in the march: alone and with a medium in front, on the density's lattice and on
// their own. Compared with the reference, and the GPU with the march in double.

#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <vector>

#include "march_cases.h"

namespace psivox {
namespace {

Field glow_in(const Box& box, const glm::dmat4& m = glm::dmat4(1)) {
  return make_field(
      box, [](glm::ivec3 v) { return 0.05f * blobs_at(glm::dvec3(v)); }, m);
}

/// Finer voxels, rotated, so that its faces lie anywhere in the density's cells.
glm::dmat4 tilted_grid() {
  const glm::dmat4 m =
      glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(-4, 5, 3)), 0.5, glm::dvec3(1, 2, 3));
  return glm::scale(m, glm::dvec3(0.9, 0.8, 0.9));
}

struct Place {
  const char* name;
  Field emission;
  bool own_lattice;
};
/// The density's box is 0,0,0 to 39,35,31. Boxes that cut the blobs have hard faces.
std::vector<Place> places() {
  std::vector<Place> all;
  all.push_back({"inside", glow_in({{4, 4, 3}, {29, 25, 21}}), false});
  all.push_back({"larger",
                 make_field({{-12, -9, -7}, {50, 44, 38}},
                            [](glm::ivec3 v) { return v.x & 4 ? 0.03f * noise(v) : 0; }),
                 false});
  all.push_back({"disjoint",
                 make_field({{50, 10, 10}, {61, 21, 21}}, [](glm::ivec3) { return 0.04f; }),
                 false});
  all.push_back({"own lattice", glow_in({{-2, -2, -2}, {41, 37, 33}}, tilted_grid()), true});
  return all;
}

View emitting(const Field& emission, LuminanceSource source, double extinction = 0.3) {
  const Scene scene = looking(small_scene(32), {80, 70, 90}, {20, 14, 14});
  View view = source == LuminanceSource::scalar
                  ? view_of(scene, blobs(), mixed())
                  : view_of(scene, blobs(),
                            source == LuminanceSource::density ? Glow::density : Glow::constant);
  view.medium.source = source;
  view.medium.extinction = extinction;
  view.medium.emission = {{share(emission), 1.5}};
  if (source == LuminanceSource::transfer)
    view.medium.transfer = function(
        {{0.1, 0, {1, 0, 0}}, {0.4, 0.7, {0.2, 1, 0}}, {0.8, 0.1, {0, 0.5, 1}}, {2, 1, {1, 1, 1}}});
  return view;
}

constexpr LuminanceSource sources[] = {LuminanceSource::constant, LuminanceSource::density,
                                       LuminanceSource::scalar, LuminanceSource::transfer};

double mean_red(const Image& image) {
  double sum = 0;
  for (std::size_t i = 0; i < image.rgba().size(); i += 4) sum += image.rgba()[i];
  return 4 * sum / double(image.rgba().size());
}

TEST(MarchEmissionDouble, PureEmissionIsItsIntegral) {
  for (const Place& place : places()) {
    View view = emitting(place.emission, LuminanceSource::constant, 0);
    const Image reference = render_reference(view).image;
    EXPECT_GE(mean_red(reference), 0.01) << place.name;
    EXPECT_EQ(mean_alpha(reference), 0);
    const Image cells = double_picture(view);
    const double rms = difference(place.name, cells, reference).rms;
    // Simpson's rule is exact for the cubics of one lattice.
    if (!place.own_lattice) {
      EXPECT_LE(rms, 1e-7) << place.name;
    }
    // Nothing attenuates: the density has no effect.
    view.medium.density =
        share(make_field({{0, 0, 0}, {39, 35, 31}}, [](glm::ivec3) { return 0; }));
    view.medium.extinction = 1;
    EXPECT_LE(difference(std::string(place.name) + ", no density", double_picture(view), cells).rms,
              1e-7);
  }
}

TEST(MarchEmissionDouble, CellExactIsTheReference) {
  for (const Place& place : places())
    for (const LuminanceSource source : sources) {
      View view = emitting(place.emission, source);
      view.scene.integrator = Integrator::cell_exact;
      const Image reference = render_reference(view).image;
      expect_content(reference);
      EXPECT_LE(
          difference(std::string(place.name) + name_of(source), double_picture(view), reference)
              .rms,
          2e-6);
    }
}

TEST(MarchEmissionDouble, SegmentsAndStepsConverge) {
  for (const Place& place : places())
    for (const LuminanceSource source : {LuminanceSource::density, LuminanceSource::scalar})
      for (const bool uniform : {false, true}) {
        View view = emitting(place.emission, source);
        const Image reference = render_reference(view).image;
        if (uniform) {
          view.scene.sampling = Sampling::uniform;
          view.scene.integrator = Integrator::psi_balanced;
        }
        // second order on kinked data; 1.4 allows for the lattice's aliasing
        expect_convergence(std::string(place.name) + name_of(source), view, reference, 1.4);
      }
}

/// If a function attenuates at 0, its medium fills the density's domain, but not the places that
/// the walk visits only for emission.
TEST(MarchEmissionDouble, WhatAttenuatesAtZeroEndsWithItsDomain) {
  for (const Place& place : places()) {
    View view = emitting(place.emission, LuminanceSource::transfer);
    view.medium.transfer = function({{0, 0.1, {1, 0, 0}}, {1, 1, {0, 1, 0}}});
    view.medium.extinction = 0.1;
    const Image reference = render_reference(view).image;
    expect_content(reference);
    view.scene.integrator = Integrator::cell_exact;
    EXPECT_LE(
        difference(std::string(place.name) + " cell-exact", double_picture(view), reference).rms,
        2e-6);
    view.scene.integrator = Integrator::psi_balanced;
    view.scene.sampling = Sampling::uniform;
    double last = HUGE_VAL;
    for (const double step : {1.0, 0.5, 0.25}) {
      view.scene.step = step;
      const double rms = difference(std::string(place.name) + " step " + std::to_string(step),
                                    double_picture(view), reference)
                             .rms;
      // second order, because steps end at the domain's faces
      EXPECT_LE(rms, 0.4 * last) << place.name;
      last = rms;
    }
  }
}

class MarchEmission : public GpuTest {};

TEST_F(MarchEmission, GpuIsTheMarchInDouble) {
  struct Way {
    Integrator rule;
    bool uniform;
    LuminanceSource source;
  };
  for (const Way& way : {Way{Integrator::psi_weighted, false, LuminanceSource::constant},
                         Way{Integrator::cell_exact, false, LuminanceSource::density},
                         Way{Integrator::psi_balanced, true, LuminanceSource::scalar}})
    for (const Place& place : places())
      for (const double extinction : {0.0, 0.3}) {
        View view = emitting(place.emission, way.source, extinction);
        view.scene.integrator = way.rule;
        if (way.uniform) view.scene.sampling = Sampling::uniform;
        view.scene.step = 0.7;
        const MediumAtlas atlas = build_medium_atlas(view);
        const Image gpu = render_gl(view, atlas).image;
        EXPECT_GE(mean_red(gpu), 0.01);
        EXPECT_LE(difference(std::string(info(way.rule).name) + ' ' + place.name + ", extinction " +
                                 std::to_string(extinction),
                             gpu, render_double(view, atlas).image)
                      .rms,
                  1e-6);
      }
}

}  // namespace
}  // namespace psivox
