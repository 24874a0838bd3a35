// Where a scene's medium gets its luminance: functions of the value before and after interpolation,
// temperatures, emission, centering, and the inputs that each mode reads.

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <cmath>
#include <memory>
#include <string>

#include "field_voxels.h"
#include "made_fields.h"
#include "medium/luminance_sources.h"
#include "psivox/error.h"
#include "psivox/medium.h"
#include "psivox/parameters.h"
#include "scene/color.h"
#include "scene/transfer_function.h"
#include "scratch.h"
#include "thrown.h"

namespace psivox {
namespace {

std::shared_ptr<const Field> shared(Field field, const char* name = "density") {
  field.name = name;
  return std::make_shared<const Field>(std::move(field));
}

float voxel(const Field& field, const glm::ivec3& at, int channel = 0) {
  return FieldVoxels(field)(at)[channel];
}

/// Values from -1 to 3 over x in 8^3 voxels.
Field ramp() {
  return make_field({{0, 0, 0}, {7, 7, 7}},
                    [](glm::ivec3 v) { return -1 + 4 * static_cast<float>(v.x) / 7; });
}

/// A scene with a transfer function, in a file.
Scene scene_by(const std::string& function, Classification when = Classification::post) {
  Scene scene;
  scene.transfer_function = test::write_bytes("function.json", function).string();
  scene.classification = when;
  return scene;
}

const char* const coloured = R"({"points": [
  {"value": 0, "attenuation": 0, "color": [0, 0, 0]},
  {"value": 1, "attenuation": 2, "color": [1, 0.5, 0.25]},
  {"value": 3, "attenuation": 1, "color": [0, 1, 4]}]})";
const char* const plain = R"({"points": [
  {"value": 0, "attenuation": 0}, {"value": 1, "attenuation": 2}, {"value": 3, "attenuation": 1}]})";
const char* const foggy = R"({"points": [
  {"value": 0, "attenuation": 0.5, "color": [1, 1, 1]},
  {"value": 3, "attenuation": 1, "color": [1, 0, 0]}]})";

/// Bytes, whole numbers up to 255 and numbers that reach far above 1 are sRGB codes; other colours
/// are linear.
TEST(LuminanceSources, ColoursOfBytesAreCodes) {
  const auto colors = [](const glm::vec3& color, const char* type, const char* name) {
    DenseField made(name, glm::ivec3(2), 3, glm::dmat4(1));
    std::vector<float> values;
    for (int i = 0; i < 8; ++i) values.insert(values.end(), {color.x, color.y, color.z});
    made.add(values);
    Field field = made.finish();
    field.value_type = type;
    const Field linear = linear_colors(std::move(field));
    return glm::vec3(FieldVoxels(linear)({0, 0, 0}));
  };
  const glm::vec3 code(255, 128, 40), resampled(200.5f, 128, 0), half(0.5f, 0.25f, 1);
  const glm::dvec3 light = linear_from_srgb(glm::dvec3(code) / 255.0);
  for (const glm::vec3& found : {colors(code, "vec3 of uint8", "rgb"), colors(code, "vec3s", "Cd"),
                                 colors(code, "vec3i", "Color")})
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(double(found[c]), light[c], 1e-7);
  EXPECT_NEAR(double(colors(resampled, "vec3s", "Cd").x),
              linear_from_srgb(glm::dvec3(200.5 / 255)).x, 1e-7);
  for (const auto& [most, bits] : {std::pair(4095.0F, 4095.0), {60000.0F, 65535.0}})
    EXPECT_NEAR(double(colors({most, 1000, 0}, "vec3 of uint16", "rgb").y),
                linear_from_srgb(glm::dvec3(1000 / bits)).x, 1e-7);
  for (const glm::vec3& linear : {half, glm::vec3(300.5f, 1, 0), glm::vec3(70000, 1, 0)})
    EXPECT_EQ(colors(linear, "vec3s", "Cd"), linear);
  EXPECT_EQ(colors(code, "vec3s", "velocity"), code);
}

TEST(TransferSource, ColoursAreTheLuminance) {
  Scene scene = scene_by(coloured);
  scene.luminance = glm::dvec3(1, 2, 3);
  const View view = make_view(scene, shared(ramp()), nullptr);
  EXPECT_EQ(view.medium.source, LuminanceSource::transfer);
  ASSERT_TRUE(view.medium.transfer);
  EXPECT_EQ(view.medium.transfer->points().size(), 3u);
  EXPECT_EQ(view.medium.color, glm::dvec3(1, 2, 3));
  EXPECT_EQ(view.medium.luminance, nullptr);
}

TEST(TransferSource, WithoutColoursLuminanceComesFromElsewhere) {
  Scene scene = scene_by(plain);
  const auto density = shared(ramp());
  EXPECT_EQ(make_view(scene, density, nullptr).medium.source, LuminanceSource::constant);
  const View other = make_view(scene, density, shared(ramp(), "heat"));
  EXPECT_EQ(other.medium.source, LuminanceSource::scalar);
  EXPECT_TRUE(other.medium.transfer);
  // L is the density itself, but negative light is clamped to none.
  const View own = make_view(scene, density, density);
  EXPECT_EQ(own.medium.source, LuminanceSource::scalar);
  EXPECT_EQ(voxel(*own.medium.luminance, {0, 0, 0}), 0.0f);
  EXPECT_EQ(voxel(*own.medium.luminance, {7, 3, 3}), 3.0f);
}

TEST(TransferSource, ColoursAndAGridAreTooMuch) {
  Scene scene = scene_by(coloured);
  scene.luminance_grid = "density";
  const std::string text =
      error_of(ExitCode::usage, [&] { make_view(scene, shared(ramp()), nullptr); });
  EXPECT_TRUE(has(text, "--luminance-grid"));
}

TEST(Colormap, TakesTheActiveRange) {
  Scene scene;
  scene.colormap = Colormap::gray;
  const View view = make_view(scene, shared(ramp()), nullptr);
  EXPECT_EQ(view.scene.range, glm::dvec2(-1, 3));
  EXPECT_EQ(view.medium.source, LuminanceSource::transfer);
  EXPECT_EQ(view.medium.transfer->at(3).color, glm::dvec3(1));
  EXPECT_EQ(view.medium.transfer->at(3).attenuation, 3);
  EXPECT_EQ(view.medium.transfer->at(-1).attenuation, 0);
  const Scene again = scene_from_json(to_json(view.scene));
  EXPECT_EQ(to_json(make_view(again, shared(ramp()), nullptr).scene), to_json(view.scene));

  // With a single value the range goes from 0 to it.
  const auto one = [](float value) {
    return shared(make_field({{0, 0, 0}, {7, 7, 7}}, [=](glm::ivec3) { return value; }));
  };
  EXPECT_EQ(make_view(scene, one(2), nullptr).scene.range, glm::dvec2(0, 2));
  EXPECT_EQ(make_view(scene, one(-2), nullptr).scene.range, glm::dvec2(-2, 0));
  EXPECT_EQ(make_view(scene, one(0), nullptr).scene.range, glm::dvec2(0, 1));
}

TEST(AutoExtinction, MeasuresWhatTheFunctionMakesOfValues) {
  Scene scene = scene_by(plain);
  const auto slab = shared(make_field({{0, 0, 0}, {15, 15, 15}}, [](glm::ivec3) { return 0.5f; }));
  // attenuation 1: every line has 16; the sums run over voxels, so they are exact within rounding
  EXPECT_NEAR(*make_view(scene, slab, nullptr).scene.extinction, 3 / 16.0, 1e-12);
  // attenuation of 0 is 0.5: 17 voxels across the domain, plus 0.5 + 0.5 * 0.5 / 3 in the slab's 16
  scene = scene_by(foggy);
  const double mean = 17 * 0.5 + 16 * 0.5 * 0.5 / 3;
  EXPECT_NEAR(*make_view(scene, slab, nullptr).scene.extinction, 3 / mean, 1e-12);
}

TEST(PreClassification, MapsVoxels) {
  const Scene scene = scene_by(coloured, Classification::pre);
  const Field field = ramp();
  const View view = make_view(scene, shared(field), nullptr);
  EXPECT_EQ(view.medium.transfer, nullptr);
  EXPECT_EQ(view.medium.source, LuminanceSource::vector);
  const TransferFunction function = read_transfer_function(scene.transfer_function);
  for (int x = 0; x < 8; ++x) {
    const double value = static_cast<double>(voxel(field, {x, 1, 2}));
    EXPECT_EQ(voxel(*view.medium.density, {x, 1, 2}),
              static_cast<float>(function.at(value).attenuation));
    for (int c = 0; c < 3; ++c)
      EXPECT_EQ(voxel(*view.medium.luminance, {x, 1, 2}, c),
                static_cast<float>(function.at(value).color[c]));
  }
  EXPECT_EQ(voxel(*view.medium.density, {-1, 1, 2}), 0.0f);
  EXPECT_EQ(view.medium.density->domain(), field.domain());
}

TEST(PreClassification, FillsTheDomainWhereNothingAttenuates) {
  const Scene scene = scene_by(foggy, Classification::pre);
  // Two leaves far apart; the space between has blocks of three widths.
  Field field = make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3) { return 3.f; });
  const Field other = make_field({{8800, 0, 0}, {8807, 7, 7}}, [](glm::ivec3) { return 3.f; });
  field.active_box.max = other.active_box.max;
  field.leaves.push_back(other.leaves[0]);
  const View view = make_view(scene, shared(field), nullptr);
  for (const Field* mapped : {view.medium.density.get(), view.medium.luminance.get()}) {
    const float nothing = mapped->channels == 1 ? 0.5f : 1.0f;
    for (const int x : {-1, 8, 100, 127, 128, 4095, 4096, 8191, 8192, 8799, 8808})
      EXPECT_EQ(voxel(*mapped, {x, 0, 0}), nothing) << x;
    EXPECT_EQ(voxel(*mapped, {0, 0, 0}), 1.0f);
    EXPECT_EQ(voxel(*mapped, {8807, 7, 7}), 1.0f);
    // Disjoint: each voxel is in one leaf or tile.
    for (const int x : {0, 8, 4096, 8800}) {
      int holders = 0;
      for (const Leaf& leaf : mapped->leaves) holders += leaf.origin == glm::ivec3(x, 0, 0);
      for (const Tile& tile : mapped->tiles)
        holders += tile.origin.x <= x && x < tile.origin.x + tile.width && tile.origin.y <= 0 &&
                   tile.origin.y + tile.width > 0 && tile.origin.z <= 0 &&
                   tile.origin.z + tile.width > 0;
      EXPECT_EQ(holders, 1) << x;
    }
  }
}

TEST(PreClassification, ColoursReachTheCornersOfCells) {
  // 0 is white and has no attenuation. The voxels around the leaf are white too, but no others.
  const Scene scene = scene_by(R"({"points": [
    {"value": 0, "attenuation": 0, "color": [1, 1, 1]},
    {"value": 3, "attenuation": 1, "color": [1, 0, 0]}]})",
                               Classification::pre);
  const View view = make_view(scene, shared(ramp()), nullptr);
  EXPECT_TRUE(view.medium.density->tiles.empty());
  EXPECT_EQ(view.medium.luminance->tiles.size(), 26u);
  EXPECT_EQ(voxel(*view.medium.luminance, {-1, 8, 3}, 1), 1.0f);
}

TEST(Temperature, IsABlackBodysAtVoxels) {
  Scene scene;
  scene.temperature_grid = "heat";
  scene.temperature_scale = 1000;
  scene.temperature_offset = 500;
  const auto density = shared(make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3) { return 1.f; }));
  const Field heat =
      make_field({{0, 0, 0}, {3, 3, 3}}, [](glm::ivec3 v) { return static_cast<float>(v.x); });
  const View view = make_view(scene, MediumFields{density, nullptr, shared(heat, "heat")});
  EXPECT_EQ(view.medium.source, LuminanceSource::vector);
  const Field& light = *view.medium.luminance;
  for (int x = 1; x < 4; ++x)
    for (int c = 0; c < 3; ++c)
      EXPECT_EQ(voxel(light, {x, 1, 1}, c), float(black_body(1000.0 * x + 500)[c]));
  // 0 means 0 K, inside and outside the leaf; it does not mean the offset.
  EXPECT_EQ(voxel(light, {0, 1, 1}, 0), 0.0f);
  EXPECT_EQ(voxel(light, {20, 1, 1}, 0), 0.0f);

  const Field vectors =
      make_vector_field({{0, 0, 0}, {3, 3, 3}}, [](glm::ivec3) { return glm::vec3(1); });
  EXPECT_NE(input_error([&] {
              make_view(scene, MediumFields{density, nullptr, shared(vectors, "heat")});
            }),
            "no error");
}

TEST(Modes, LookAtTheirTermsOnly) {
  Scene scene;
  scene.emission_grid = "fire";
  scene.emission_scale = 4;
  scene.luminance_grid = "heat";
  scene.luminance = glm::dvec3(1, 2, 3);
  scene.lights = {{}};
  const auto density = shared(ramp());
  const MediumFields fields{
      density, shared(ramp(), "heat"), nullptr, {{&emission_options[0], shared(ramp(), "fire")}}};
  const View alpha = make_view(scene, fields);
  ASSERT_EQ(alpha.medium.emission.size(), 1u);
  EXPECT_EQ(alpha.medium.emission[0].field, fields.emission.at(0).field);
  EXPECT_EQ(alpha.medium.emission[0].scale, 4);
  EXPECT_EQ(alpha.medium.source, LuminanceSource::scalar);
  ASSERT_TRUE(alpha.medium.light);
  EXPECT_EQ(alpha.medium.light->lights.at(0).direction, glm::dvec3(0, -1, 0));
  EXPECT_EQ(alpha.scene.emission_grid, "fire");
  for (const Mode mode : {Mode::mip, Mode::lmip, Mode::isosurface, Mode::xray}) {
    scene.mode = mode;
    const View view = make_view(scene, fields);
    EXPECT_TRUE(view.medium.emission.empty());
    const bool surface = scene.shows(Shows::surface);  // grids colour it
    EXPECT_EQ(view.medium.luminance != nullptr, surface);
    EXPECT_EQ(view.medium.source, surface                     ? LuminanceSource::scalar
                                  : scene.shows(Shows::value) ? LuminanceSource::transfer
                                                              : LuminanceSource::constant);
    EXPECT_EQ(view.medium.light, std::nullopt);
    EXPECT_EQ(view.medium.color, glm::dvec3(1, 2, 3));
    EXPECT_EQ(view.scene.extinction.has_value(), mode == Mode::xray);
    // Parameters that this mode ignores stay in the scene for the next mode.
    EXPECT_EQ(view.scene.emission_grid, "fire");
  }
}

TEST(Modes, IsovalueIsTheMiddleOrADistance) {
  const double below = 4e-6 * 3;  // of the greatest value, so that a plateau is no surface
  Scene scene;
  scene.mode = Mode::isosurface;
  View view = make_view(scene, shared(ramp()), nullptr);
  EXPECT_EQ(view.medium.surfaces.front().isovalue, 1 - below);  // the middle of -1 and 3
  EXPECT_EQ(view.scene.isovalue.front().value, 1);
  scene.isovalue = {{-0.5}};
  EXPECT_EQ(make_view(scene, shared(ramp()), nullptr).medium.surfaces.front().isovalue,
            -0.5 - below);

  Field level_set = ramp();
  level_set.half_width = 1.5;
  view = make_view(scene, shared(level_set), nullptr);
  EXPECT_EQ(view.scene.isovalue.front().value, -0.5);
  EXPECT_EQ(view.medium.surfaces.front().isovalue, 2 - below);  // 0.5 inside
  scene.isovalue.clear();
  view = make_view(scene, shared(level_set), nullptr);
  EXPECT_EQ(view.scene.isovalue.front().value, 0);
  EXPECT_EQ(view.medium.surfaces.front().isovalue, 1.5 - below);
  scene.isovalue = {{1.5}};
  EXPECT_NE(usage_error([&] { make_view(scene, shared(level_set), nullptr); }), "no error");

  // The function's colour at the surface, where the value is constant.
  scene.isovalue = {{1}};
  scene.transfer_function = scene_by(coloured).transfer_function;
  view = make_view(scene, shared(ramp()), nullptr);
  EXPECT_EQ(view.medium.transfer, nullptr);
  EXPECT_EQ(view.medium.source, LuminanceSource::constant);
  EXPECT_EQ(view.medium.surfaces.front().color, glm::dvec3(1, 0.5, 0.25));
}

TEST(Centering, CellShiftsEveryGridByHalfAVoxel) {
  Scene scene;
  scene.centering = Centering::cell;
  scene.emission_grid = "fire";
  const Field ones = make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3) { return 1.f; });
  Field fire = ones;
  fire.world_from_index = glm::dmat4(glm::dmat3(3));
  const auto density = shared(ones);
  const View view = make_view(
      scene,
      MediumFields{density, density, nullptr, {{&emission_options[0], shared(fire, "fire")}}});
  EXPECT_EQ(view.medium.density->world_from_index[3], glm::dvec4(0.5, 0.5, 0.5, 1));
  EXPECT_EQ(view.medium.emission.at(0).field->world_from_index[3], glm::dvec4(1.5, 1.5, 1.5, 1));
  EXPECT_EQ(view.medium.source, LuminanceSource::density);
  scene.centering = Centering::node;
  const View node = make_view(
      scene,
      MediumFields{density, density, nullptr, {{&emission_options[0], shared(fire, "fire")}}});
  // The camera frames both; the fire is the larger. Its target, about 12, is rounded a few times.
  const glm::dvec3 moved = *view.scene.camera_target - *node.scene.camera_target;
  EXPECT_LE(glm::length(moved - glm::dvec3(1.5)), 1e-14);
}

TEST(Light, AloneIsAllTheLuminance) {
  Scene scene;
  scene.lights = {{{0, 0, -2}, {1, 2, 3}}};
  scene.albedo = glm::dvec3(0.5);
  const auto density = shared(ramp());
  View view = make_view(scene, density, nullptr);
  EXPECT_EQ(view.scene.luminance, glm::dvec3(0));
  EXPECT_EQ(view.medium.color, glm::dvec3(0));
  ASSERT_TRUE(view.medium.light);
  EXPECT_EQ(view.medium.light->lights.at(0).direction, glm::dvec3(0, 0, -1));
  EXPECT_EQ(view.medium.light->lights.at(0).radiance, glm::dvec3(0.5, 1, 1.5));
  // A grid still glows, and so does luminance that is asked for.
  EXPECT_EQ(make_view(scene, density, density).scene.luminance, glm::dvec3(1));
  scene.luminance = glm::dvec3(2);
  EXPECT_EQ(make_view(scene, density, nullptr).medium.color, glm::dvec3(2));
  scene.phase_g = 0.5;
  EXPECT_EQ(make_view(scene, density, nullptr).medium.color, glm::dvec3(2));
}

TEST(Light, PhaseIsHenyeyAndGreensteins) {
  Medium medium;
  EXPECT_EQ(phase_factor(medium, {0, 0, 1}), 1);
  medium.phase_axis = {0, 0, 1};
  medium.phase_g = 0.6;
  // Towards the light's source scattering is forward: (1 - g^2) / (1 - g)^3.
  EXPECT_NEAR(phase_factor(medium, {0, 0, -1}), 0.64 / 0.064, 1e-12);
  EXPECT_NEAR(phase_factor(medium, {0, 0, 1}), 0.64 / 4.096, 1e-12);
  // Its mean over all directions is 1. Midpoint rule over the cosine: at 2000 points the error is
  // below 1e-5, since it is (1/24) 2/n^2 times the mean second derivative, which is below 100.
  double sum = 0;
  constexpr int n = 2000;
  for (int i = 0; i < n; ++i) {
    const double z = (2.0 * i + 1) / n - 1;
    sum += phase_factor(medium, {std::sqrt(1 - z * z), 0, z}) / n;
  }
  EXPECT_NEAR(sum, 1, 1e-4);
}

}  // namespace
}  // namespace psivox
