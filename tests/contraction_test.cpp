// Shows that the march ends and keeps its bounds where a compiler makes fused multiply-adds of some
// of its sums and not of others, as GPUs' compilers do: the shaders, compiled for the CPU in float
// with contraction and without, march their own rays and each other's.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "float_march.h"
#include "march/film.h"
#include "march/march_double.h"
#include "psivox/draw.h"
#include "psivox/image.h"
#include "verify/case.h"

namespace psivox {
namespace {

/// Draws in float; computes light in double.
class FloatMarcher : public DoubleMarcher {
 public:
  /// `maker` makes the rays that `march` marches.
  FloatMarcher(const FloatMarch& maker, const FloatMarch& march)
      : make_rays_(maker.make_rays), march_(march.march) {}

  void upload(const MediumAtlas& atlas, Filter filter) override {
    atlas_ = &atlas;
    DoubleMarcher::upload(atlas, filter);
  }

  RenderResult render(const View& view, const RenderOptions& options) override {
    const MarchSetup setup = make_march_setup(view, *atlas_, options);
    const int width = view.scene.resolution.x;
    std::vector<FloatRay> drawn(std::size_t(width) * std::size_t(view.scene.resolution.y));
    make_rays_(setup, *atlas_, width, drawn);
    march_(setup, *atlas_, width, drawn);
    RenderResult result;
    Film film(view, options);
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      PixelSums sums;
      sums.add(glm::dvec4(drawn[i].picture), glm::dvec4(no_depth));
      film.set(int(i) % width, int(i) / width, sums);
      result.stats.stuck += drawn[i].stuck;
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
#ifdef __x86_64__
    if (!__builtin_cpu_supports("fma")) GTEST_SKIP() << "this machine has no fused multiply-add";
#endif
  }

  void TearDown() override {
    expect_same_ends(plain, plain_fused);
    expect_same_ends(fused, fused_plain);
  }

  /// Both have ended every ray at the same place, to the last bit.
  static void expect_same_ends(const FloatMarcher& a, const FloatMarcher& b) {
    ASSERT_EQ(a.rays.size(), b.rays.size());
    std::size_t stuck = 0, elsewhere = 0;
    for (std::size_t i = 0; i < a.rays.size(); ++i) {
      stuck += a.rays[i].stuck || b.rays[i].stuck;
      elsewhere += a.rays[i].reached != b.rays[i].reached;
    }
    EXPECT_EQ(stuck, 0u);
    EXPECT_EQ(elsewhere, 0u);
  }

  // whose rays, and whose march
  FloatMarcher plain{plain_march, plain_march}, plain_fused{plain_march, fused_march};
  FloatMarcher fused{fused_march, fused_march}, fused_plain{fused_march, plain_march};
  FloatMarcher* const all[4] = {&plain, &plain_fused, &fused, &fused_plain};
};

// cells, uniform steps; functions, light, emission; back to front
TEST_F(Contraction, VerifyPasses) {
  for (const Case& c : verify_cases())
    for (FloatMarcher* marcher : all) {
      const VerifyCase found = run_case(c, *marcher, Filter::exact);
      EXPECT_TRUE(found.passed()) << c.name << ": " << found.error << " over " << found.bound
                                  << ", " << found.stuck << " rays stood still";
    }
}

// On Mesa 25 some of these pictures had rays that never ended.
TEST_F(Contraction, BackToFrontEnds) {
  Scene scene;
  scene.input = std::string(PSIVOX_ASSETS) + "/ramp.vdb";
  scene.transfer_function = std::string(PSIVOX_ASSETS) + "/shells.json";
  scene.mode = Mode::back_to_front;
  scene.resolution = {96, 54};
  scene.sampling = Sampling::cells;
  Session session(scene);
  const auto exact = open_double();
  for (int azimuth = 13; azimuth < 360; azimuth += 40)
    for (const double elevation : {-50.0, 0.0, 20.0}) {
      scene.azimuth = azimuth;
      scene.elevation = elevation;
      const Image truth = session.draw(*exact, {.scene = scene}).image;
      // the bound of the march on the GPU in MarchModes.BackToFrontIsAlpha
      for (FloatMarcher* marcher : all)
        EXPECT_LE(compare_images(session.draw(*marcher, {.scene = scene}).image, truth).rms, 1e-6)
            << azimuth << ", " << elevation;
    }
}

}  // namespace
}  // namespace psivox
