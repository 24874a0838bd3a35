// Thin peaks of a transfer function on real data, two segments per cell. Compares pre-integration,
// and pieces between knots, with samples of the function.

#include <string>

#include "march_cases.h"
#include "psivox/vdb.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

/// Two tents of changing colour, 2 % of the range wide on either side of their peaks.
TransferFunction peaks(double low, double high) {
  const auto at = [&](double share) { return low + share * (high - low); };
  return TransferFunction({{at(0.23), 0, {1, 0, 0}},
                           {at(0.25), 1, {1, 0.5, 0}},
                           {at(0.27), 0, {1, 1, 0}},
                           {at(0.58), 0, {0, 0, 1}},
                           {at(0.60), 1, {0, 0.5, 1}},
                           {at(0.62), 0, {0.5, 1, 1}}});
}

class MarchClassification : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(File, MarchClassification, testing::Values("heptane", "mri_t1"),
                         [](const auto& i) { return std::string(i.param); });

TEST_P(MarchClassification, ThinPeaksAreNotSampledAway) {
  const auto path = shared_data() / (std::string(GetParam()) + ".vdb");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no file " << path << " (PSIVOX_DATA)";
  const VdbFile file(path);
  const auto density = share(file.read(file.default_grid()));
  float low = density->leaves.front().values[0], high = low;
  for (const Leaf& leaf : density->leaves) {
    const auto [min, max] = std::minmax_element(leaf.values, leaf.values + 512);
    low = std::min(low, *min);
    high = std::max(high, *max);
  }
  Scene scene = small_scene(96);
  scene.segments = 2;
  View view = view_of(scene, density);
  view.camera =
      make_camera(scene, view.subject->box_min, view.subject->box_max);  // all peaks, seen or not
  view.medium.transfer = std::make_shared<const TransferFunction>(peaks(low, high));
  view.medium.source = LuminanceSource::transfer;
  const double extinction = auto_extinction(*density, view.medium.transfer.get());
  // peaks that transmit light, and peaks that act as surfaces
  for (const double denser : {1.0, 10.0}) {
    view.medium.extinction = denser * extinction;
    const MediumAtlas atlas = build_medium_atlas(view);
    const Image reference = render_reference(view).image;
    expect_content(reference, 0.05);
    const auto error = [&](Integrator rule) {
      View v = view;
      v.scene.integrator = rule;
      return difference(std::string(GetParam()) + ", extinction x" + std::to_string(int(denser)) +
                            ", " + info(rule).name,
                        render_double(v, atlas).image, reference)
          .rms;
    };
    const double sampled = error(Integrator::psi_weighted);
    const double preintegrated = error(Integrator::preintegrated);
    const double exact = error(Integrator::cell_exact);
    std::printf("  preintegrated %.1f times better, cell-exact %.0f times\n",
                sampled / preintegrated, sampled / exact);
    EXPECT_LE(5 * preintegrated, sampled);
    EXPECT_LE(30 * exact, sampled);
    EXPECT_LE(exact, 2e-6);
    if (!Gpu::renderer()) continue;
    for (const Integrator rule : {Integrator::preintegrated, Integrator::cell_exact}) {
      View v = view;
      v.scene.integrator = rule;
      const double gpu =
          difference(std::string(info(rule).name) + ", GPU", render_gl(v, atlas).image, reference)
              .rms;
      EXPECT_LE((rule == Integrator::cell_exact ? 30 : 5) * gpu, sampled);
    }
  }
}

}  // namespace
}  // namespace psivox
