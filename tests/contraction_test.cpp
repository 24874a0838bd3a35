// Shows that the march neither hangs nor errs where a compiler makes fused multiply-adds of some of
// its sums, as GPUs' compilers do: its source, compiled for the CPU in float with contraction and
// without.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "float_march.h"
#include "march/film.h"
#include "march/march_double.h"
#include "psivox/image.h"
#include "verify/case.h"
#include "verify/made_views.h"

namespace psivox {
namespace {

/// Draws in float; computes light in double.
class FloatMarcher : public DoubleMarcher {
 public:
  /// `rays` makes the rays that `march` marches.
  FloatMarcher(const FloatMarch& rays, const FloatMarch& march)
      : make_rays_(rays.make_rays), march_(march.march) {}

  void upload(const MediumAtlas& atlas, Filter filter) override {
    atlas_ = &atlas;
    DoubleMarcher::upload(atlas, filter);
  }

  RenderResult render(const View& view, const RenderOptions& options) override {
    MarchSetup setup = make_march_setup(view, *atlas_, options);
    const int width = view.scene.resolution.x;
    std::vector<FloatRay> drawn(std::size_t(width) * std::size_t(view.scene.resolution.y));
    if (getenv("MT"))
      setup.parameters.max_turns = std::min(setup.parameters.max_turns, atoi(getenv("MT")));
    make_rays_(setup, *atlas_, width, drawn);
    march_(setup, *atlas_, width, drawn);
    RenderResult result;
    Film film(view, options);
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      PixelSums sums;
      sums.add(glm::dvec4(drawn[i].picture), glm::dvec4(no_depth));
      film.set(int(i) % width, int(i) / width, sums);
    }
    result.image = film.finish(result.stats);
    rays.insert(rays.end(), drawn.begin(), drawn.end());
    return result;
  }

  std::vector<FloatRay> rays;  ///< of all pictures

 private:
  FloatMarch::Pixels make_rays_, march_;
  const MediumAtlas* atlas_ = nullptr;
};

class Contraction : public testing::Test {
 protected:
  void SetUp() override {
#if defined(__x86_64__)
    if (!__builtin_cpu_supports("fma")) GTEST_SKIP() << "no fused multiply-add on this machine";
#endif
  }

  void expect_ends(const std::string& name) {
    ends(name, plain, mixed);
    ends(name, fused, mixed2);
  }
  /// Both marches have ended every ray, at the same place but for rounding.
  void ends(const std::string& name, FloatMarcher& a, FloatMarcher& b) {
    ASSERT_EQ(a.rays.size(), b.rays.size());
    std::size_t endless = 0, elsewhere = 0;
    long tp = 0, tf = 0;
    for (std::size_t i = 0; i < a.rays.size(); ++i) {
      endless += a.rays[i].stuck;
      endless += b.rays[i].stuck;
      elsewhere += a.rays[i].reached != b.rays[i].reached;
      tp += a.rays[i].turns;
      tf += b.rays[i].turns;
    }
    printf("%s: %zu rays, endless %zu elsewhere %zu turns %ld %ld\n", name.c_str(), a.rays.size(),
           endless, elsewhere, tp, tf);
    EXPECT_EQ(endless, 0u) << name;
    EXPECT_EQ(elsewhere, 0u) << name;
    a.rays.clear();
    b.rays.clear();
  }

  FloatMarcher plain{plain_march, plain_march}, mixed{plain_march, fused_march};
  FloatMarcher fused{fused_march, fused_march}, mixed2{fused_march, plain_march};
};

TEST_F(Contraction, VerifyPasses) {
  for (const auto& group : {opacity_cases(), radiance_cases(), source_cases(), invariance_cases()})
    for (const Case& c : group) {
      for (FloatMarcher* marcher : {&plain, &mixed, &fused, &mixed2}) {
        const VerifyCase found = run_case(c, Painter(*marcher, Filter::exact));
        EXPECT_TRUE(found.passed()) << c.name << ": " << found.error << " over " << found.bound;
      }
      expect_ends(c.name);
    }
}

TEST_F(Contraction, BackToFrontEnds) {
  Scene scene;
  scene.input = std::string(PSIVOX_ASSETS) + "/ramp.vdb";
  scene.transfer_function = std::string(PSIVOX_ASSETS) + "/shells.json";
  scene.mode = Mode::back_to_front;
  scene.resolution = {96, 54};
  scene.sampling = Sampling::cells;
  Session session(scene);
  const auto exact = open_double();
  for (int azimuth = 13; azimuth < 360; azimuth += 20)
    for (const double elevation : {-50.0, 0.0, 20.0}) {
      scene.azimuth = azimuth;
      scene.elevation = elevation;
      const Image truth = session.draw(*exact, {.scene = scene}).image;
      for (FloatMarcher* marcher : {&plain, &mixed, &fused, &mixed2}) {
        auto c = compare_images(session.draw(*marcher, {.scene = scene}).image, truth);
        printf("rms %g max %g\n", c.rms, c.max);
      }
      expect_ends(std::to_string(azimuth) + ", " + std::to_string(elevation));
    }
}

}  // namespace
}  // namespace psivox
