// Voxels without data, and labels: what no mode may interpolate.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "base/text.h"
#include "field/value_range.h"
#include "march_cases.h"
#include "medium/density_function.h"
#include "psivox/draw.h"
#include "psivox/open.h"
#include "psivox/parameters.h"
#include "psivox/picture_file.h"
#include "psivox/vdb.h"
#include "scratch.h"
#include "thrown.h"

namespace psivox {
namespace {

constexpr float no_data = std::numeric_limits<float>::quiet_NaN();
constexpr int voxels_across = 28;

/// An array of values at places from -1 to 1.
template <typename Value>
std::shared_ptr<const VolumeFile> array_of(const Value& value) {
  DenseField made("values", glm::ivec3(voxels_across), 1, glm::dmat4(1));
  std::vector<float> slab;
  for (int x = 0; x < voxels_across; ++x) {
    for (int y = 0; y < voxels_across; ++y)
      for (int z = 0; z < voxels_across; ++z)
        slab.push_back(value(glm::dvec3(x, y, z) / (0.5 * (voxels_across - 1)) - 1.0));
    if (x % 8 == 7 || x == voxels_across - 1) {
      made.add(slab);
      slab.clear();
    }
  }
  return std::make_shared<VolumeFile>(std::make_shared<const Field>(made.finish()));
}

/// All values are below 0, as decibels are; there are none beside a ball.
std::shared_ptr<const VolumeFile> decibels() {
  return array_of([](const glm::dvec3& p) {
    const double r = glm::length(p);
    return r < 0.8 ? float(-20 - 80 * r + 6 * std::sin(9 * p.x)) : no_data;
  });
}

Scene scene_by(const std::vector<Setting>& settings) {
  Scene scene;
  scene.resolution = {40, 40};
  scene.look = "plain";
  for (const Setting& setting : settings) set_parameter(scene, setting.name, setting.text);
  return scene;
}

class AbsentVoxels : public GpuTest {};

/// The GPU, the march in double and the reference agree, nothing is seen in front of no data, and
/// nothing that is seen is beyond the data.
TEST_F(AbsentVoxels, AreVacuumToEveryMode) {
  const auto file = decibels();
  const std::string steep = test::write_bytes("steep.json", R"({"gradients": [0, 10], "points": [
    {"value": -100, "attenuation": [0.2, 1]}, {"value": 0, "attenuation": [0.2, 1]}]})")
                                .string();
  const std::vector<std::vector<Setting>> cases = {
      {{"classification", "pre"}, {"opacity", "0:0.2,1:1"}},
      {{"classification", "pre"}, {"transfer-function", steep}},
      {{"colormap", "viridis"}, {"opacity", "0:0.2,1:1"}},
      {{"colormap", "viridis"}, {"opacity", "0:0.2,1:1"}, {"light", "1,-1,-1"}},
      {{"opacity", "0:1,1:0"}, {"integrator", "cell-exact"}},
      {{"opacity", "0:1,1:1"}, {"texel", "code7"}},
      {{"mode", "mip"}, {"range", "-100,0"}},
      {{"mode", "lmip"}, {"range", "-100,0"}, {"lmip-threshold", "-50"}},
      {{"mode", "minip"}, {"range", "-100,0"}},
      {{"mode", "mean"}, {"range", "-100,0"}},
      {{"mode", "isosurface"}, {"isovalue", "-60"}},
      {{"mode", "xray"}, {"opacity", "0:1,1:1"}},
      {{"mode", "slice"}, {"colormap", "viridis"}}};
  for (const std::vector<Setting>& settings : cases) {
    Scene scene = scene_by(settings);
    scene.early_termination = 0;
    const View view = make_view(scene, *file);
    SCOPED_TRACE(to_json(scene));
    Session session(view);
    const Image gpu = session.draw(*Gpu::renderer()).image;
    expect_content(gpu);
    const bool coded = has_codes(scene.texel);
    const Image exact = session.draw(*open_reference()).image;
    EXPECT_LE(difference("GPU and reference", gpu, exact).rms, coded ? 2e-2 : 2e-4);
    EXPECT_LE(difference("double and reference", session.draw(*open_double()).image, exact).rms,
              2e-4);
    EXPECT_EQ(gpu.rgba()[3], 0) << "a corner, where there are no data";
  }
}

TEST_F(AbsentVoxels, AreMetByStepsToo) {
  const auto file = decibels();
  double before = 0;
  for (const char* step : {"1", "0.5", "0.25", "0.125"}) {
    Scene scene = scene_by({{"colormap", "viridis"}, {"opacity", "0:0.2,1:1"}, {"step", step}});
    scene.early_termination = 0;
    Session session(make_view(scene, *file));
    const double rms = difference(step, session.draw(*Gpu::renderer()).image,
                                  session.draw(*open_reference()).image)
                           .rms;
    // a step that begins or ends at a face of vacuum is of first order
    if (before > 0) {
      EXPECT_LT(rms, 0.75 * before) << step;
    }
    before = rms;
  }
}

TEST_F(AbsentVoxels, AreSeenByNoStatistic) {
  const auto file = decibels();
  const MediumFields fields = read_fields(scene_by({{"colormap", "viridis"}}), *file);
  const Field& field = *fields.density;
  EXPECT_TRUE(field.absent);
  EXPECT_LT(stored_range(field).y, 0.1);
  EXPECT_LT(active_range(field).y, -10);
  EXPECT_GT(active_range(field).x, -100);
  EXPECT_LT(active_percentile(field, 99.9), -10);
}

TEST_F(AbsentVoxels, CountForNoThreshold) {
  // half of what is known is 3; of what is less a fifth is 1 and the rest is 2
  const auto file = array_of([](const glm::dvec3& p) {
    if (p.x < 0) return no_data;
    return p.y < 0 ? 3.0f : p.z < -0.6 ? 1.0f : 2.0f;
  });
  const double threshold = otsu_threshold(*read_fields(scene_by({}), *file).density);
  EXPECT_GT(threshold, 2);
  EXPECT_LT(threshold, 3);
}

TEST_F(AbsentVoxels, AddNothingToTheAutomaticDepth) {
  // in a box a ball of opaque values, beside which there are none, or some that attenuate nothing
  const auto extinction_beside = [](float beside) {
    const auto file = array_of([&](const glm::dvec3& p) {
      const glm::dvec3 q = glm::abs(p);
      if (std::max({q.x, q.y, q.z}) > 0.98) return 0.1f;
      return glm::length(p) < 0.5 ? 2.0f : beside;
    });
    const Scene scene = scene_by({{"range", "0,2"}, {"opacity", "0:0,0.4:0,0.5:1,1:1"}});
    return make_view(scene, *file).medium.extinction;
  };
  // opacities are float32
  EXPECT_NEAR(extinction_beside(no_data) / extinction_beside(0.1f), 1, 1e-6);
}

/// An organ and a small tumour in it.
float organ(const glm::dvec3& p) {
  if (glm::length(p - glm::dvec3(0.3, 0, 0)) < 0.25) return 2;
  return glm::length(p) < 0.85 ? 1 : 0;
}

TEST_F(AbsentVoxels, LabelsAreAllSeenAndNeverBetween) {
  const auto file = array_of(organ);
  Scene scene = scene_by({{"colormap", "labels"}, {"classification", "nearest"}});
  scene.early_termination = 0;
  for (const auto& more : std::vector<std::vector<Setting>>{
           {},
           {{"light", "1,-1,-1"}},
           {{"light", "1,-1,-1"}, {"texel", "code7"}},
           {{"light", "1,-1,-1"}, {"classification", "nearest"}, {"opacity", "0:0,1:1"}},
           {{"integrator", "cell-exact"}},
           {{"texel", "code12"}},
           {{"clip", "0,0,0,20.3,15,30"}},
           {{"mode", "mean"}},
           {{"mode", "mip"}}}) {
    Scene own = scene;
    for (const Setting& setting : more) set_parameter(own, setting.name, setting.text);
    SCOPED_TRACE(to_json(own));
    Session session(make_view(own, *file));
    const Image gpu = session.draw(*Gpu::renderer()).image;
    const Image exact = session.draw(*open_reference()).image;
    EXPECT_LE(difference("GPU and reference", gpu, exact).rms, own.lit() ? 1e-3 : 2e-5);
    const float* organ_alone = gpu.rgba().data() + 4 * (20 * 40 + 12);
    EXPECT_GT(organ_alone[3], 0.5);
  }
}

/// Voxels up to the border of an array are whole, of values below 0 too, beside which nothing is
/// known: a ray through the middle meets as many voxels as there are.
TEST_F(AbsentVoxels, TheLastVoxelsOfLabelsAreWhole) {
  for (const float left : {3.0F, -3.0F}) {
    const auto file = array_of([&](const glm::dvec3& p) { return p.x < 0 ? left : 2; });
    Scene scene = scene_by({{"classification", "nearest"},
                            {"range", "-4,4"},
                            {"opacity", "0:1,0.45:1,0.5:0,0.55:1,1:1"},
                            {"fill-value", "none"},
                            {"extinction", "0.25"},
                            {"mode", "xray"},
                            {"projection", "orthographic"},
                            {"azimuth", "90"},
                            {"luminance", "white"}});
    Session session(make_view(scene, *file));
    const Image gpu = session.draw(*Gpu::renderer()).image;
    const Image exact = session.draw(*open_reference()).image;
    EXPECT_LE(difference("GPU and reference", gpu, exact).rms, 2e-5);
    EXPECT_NEAR(exact.rgba()[4 * (20 * 40 + 20)], 0.25 * voxels_across, 1e-5);
  }
}

/// A function of one's own does not interpolate them either, unless it is asked to.
TEST(Labels, AreNearestUnderAFunction) {
  const auto file = array_of([](const glm::dvec3& p) {  // 27 of them
    const glm::ivec3 place(1.4999 * (p + 1.0));
    return float(1 + place.x + 3 * place.y + 9 * place.z);
  });
  const auto classification = [&](std::vector<Setting> settings) {
    Scene scene;
    settings.push_back({"transfer-function", PSIVOX_ASSETS "/shells.json"});
    for (const Setting& setting : settings) set_parameter(scene, setting.name, setting.text);
    return with_look(scene, *file, "auto").scene.classification;
  };
  EXPECT_EQ(classification({}), Classification::nearest);
  EXPECT_EQ(classification({{"mode", "slice"}}), Classification::nearest);
  EXPECT_EQ(classification({{"classification", "post"}}), Classification::post);
}

/// What surrounds an object is transparent at any value: the same everywhere or noisy, in many
/// voxels or few; and it makes no labels of smooth values, but few whole numbers are.
TEST(Labels, AreToldFromObjectsInBrightSurroundings) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  const auto ball = [](const glm::dvec3& p) { return std::exp(-6 * glm::dot(p, p)); };
  const auto look_of = [](const std::shared_ptr<const VolumeFile>& file) {
    Scene scene;
    scene.resolution = {48, 48};
    return with_look(scene, *file, "auto").scene;
  };
  const auto corner_and_middle = [&](const Scene& scene, const VolumeFile& file) {
    const Image image = Session(make_view(scene, file)).draw(*Gpu::renderer()).image;
    return glm::dvec2(image.rgba()[4 * (24 * 48 + 8) + 3], image.rgba()[4 * (24 * 48 + 24) + 3]);
  };
  const std::function<float(const glm::dvec3&)> objects[] = {
      [&](const glm::dvec3& p) { return float(255 - std::floor(200 * ball(p))); },
      [&](const glm::dvec3& p) { return float(65000 - 60000 * ball(p) + 200 * noise(random)); },
      [&](const glm::dvec3& p) { return float(std::min(glm::length(p), 0.8) - 0.5); },
      [&](const glm::dvec3& p) { return float(std::exp(-3 * ball(p))); },
      // padding of -2000 in unsigned numbers
      [&](const glm::dvec3& p) {
        return float(std::hypot(p.x, p.y) > 0.95 ? 63536 : 1000 * ball(p) + noise(random));
      }};
  for (const auto& object : objects) {
    const auto file = array_of(object);
    Scene scene = look_of(file);
    EXPECT_NE(scene.colormap, Colormap::labels);
    scene.background.reset();
    const glm::dvec2 alpha = corner_and_middle(scene, *file);
    EXPECT_LT(alpha.x, 0.5) << &object - objects;
    EXPECT_GT(alpha.y, alpha.x + 0.2) << &object - objects;
  }
  EXPECT_EQ(look_of(array_of(organ)).colormap, Colormap::labels);
  for (const float outside : {255.0F, -1.0F}) {  // of labels, too
    const auto file = array_of([&](const glm::dvec3& p) {
      const float label = organ(p);
      return label > 0 ? label : outside;
    });
    Scene scene = look_of(file);
    EXPECT_EQ(scene.colormap, Colormap::labels);
    scene.background.reset();
    const glm::dvec2 alpha = corner_and_middle(scene, *file);
    scene.color_bar = "";
    const Drawn drawn = Session(make_view(scene, *file), true).draw(*Gpu::renderer());
    EXPECT_EQ(color_scale(drawn.view)->labels, (std::vector<double>{1, 2}));
    scene = {};
    set_parameter(scene, "mode", "slice");
    EXPECT_EQ(with_look(scene, *file, "auto").scene.colormap, Colormap::labels);
    EXPECT_LT(alpha.x, 1e-3) << outside;
    EXPECT_GT(alpha.y, 0.5) << outside;
  }
  const auto equal = array_of([](const glm::dvec3&) { return 5.0F; });  // nothing else is there
  EXPECT_GT(corner_and_middle(look_of(equal), *equal).y, 0.5);
}

TEST_F(AbsentVoxels, AFillValueIsNamedAsItIs) {
  for (const float fill : {1e20F, -1e20F, 9.96921e36F, -9999.0F}) {
    const auto file = array_of([&](const glm::dvec3& p) {
      return glm::length(p) < 0.8 ? float(3 + std::sin(9 * p.x)) : fill;
    });
    const MediumFields fields = read_fields(scene_by({{"colormap", "viridis"}}), *file);
    const std::string notice = fields.density->replaced.describe();
    EXPECT_TRUE(has(notice, formatted(" values of %g taken", double(fill))));
  }
}

}  // namespace
}  // namespace psivox
