// What a view resolves: `auto` extinction on fields with known integrals, optional parameters, and
// the source of luminance.

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <vector>

#include "made_fields.h"
#include "psivox/medium.h"
#include "psivox/parameters.h"
#include "scene/transfer_function.h"
#include "thrown.h"

namespace psivox {
namespace {

TEST(AutoExtinction, GivesASlabsAxesTheMeanDepth) {
  // 16^3 voxels of 0.5: every line through the middle half has the integral 16 * 0.5 * 0.25.
  const glm::dmat4 scale = glm::scale(glm::dmat4(1), glm::dvec3(0.25));
  const Field field = make_field(
      {{0, 0, 0}, {15, 15, 15}}, [](glm::ivec3) { return 0.5f; }, scale);
  EXPECT_NEAR(auto_extinction(field), 3 / 2.0, 1e-12);
}

TEST(AutoExtinction, MeasuresEachAxisInTheWorld) {
  const glm::dmat4 scale = glm::scale(glm::dmat4(1), glm::dvec3(1, 2, 3));
  const Field field = make_field(
      {{0, 0, 0}, {15, 15, 15}}, [](glm::ivec3) { return 1.f; }, scale);
  EXPECT_NEAR(auto_extinction(field), 3 / (16.0 * (1 + 2 + 3) / 3), 1e-12);
}

TEST(AutoExtinction, TakesTilesAndLeavesAlike) {
  const auto one = [](glm::ivec3) { return 1.f; };
  const Field leaves = make_field({{0, 0, 0}, {23, 23, 23}}, one);
  Field tiles = leaves;
  tiles.leaves.clear();
  for (const Leaf& leaf : leaves.leaves) tiles.tiles.push_back({leaf.origin, 8, glm::vec3(1)});
  EXPECT_EQ(auto_extinction(tiles), auto_extinction(leaves));
  EXPECT_NEAR(auto_extinction(tiles), 3 / 24.0, 1e-12);
}

TEST(AutoExtinction, LeavesOutWhatIsOutsideTheDomain) {
  // An inactive voxel just outside the active box ends the domain: its tent is cut in half.
  Field field = make_field({{0, 0, 0}, {6, 7, 7}}, [](glm::ivec3) { return 1.f; });
  auto values = std::make_shared<std::vector<float>>(512, 1.f);  // x = 7 is stored but inactive
  field.leaves[0].values = values->data();
  field.storage = values;
  // x lines: 7 voxels and half of the eighth; y and z lines: 8.
  EXPECT_NEAR(auto_extinction(field), 3 / ((7.5 + 8 + 8) / 3), 1e-12);
}

TEST(AutoExtinction, WidensToTheDomainAndToTheDensestVoxel) {
  const auto shell = [](glm::ivec3 v) { return v.y < 4 && v.z < 4 ? 1.f : 0.f; };
  EXPECT_NEAR(auto_extinction(make_field({{0, 0, 0}, {31, 3, 3}}, shell)), 3 / ((32 + 4 + 4) / 3.0),
              1e-12);
  // Two voxels at the ends of a long diagonal, which no lattice ray meets.
  const auto sparse = [](glm::ivec3 v) {
    return v == glm::ivec3(0) ? 1.f : v == glm::ivec3(255) ? 2.f : 0.f;
  };
  EXPECT_NEAR(auto_extinction(make_field({{0, 0, 0}, {255, 255, 255}}, sparse)), 3 / 2.0, 1e-12);
  const auto corner = [](glm::ivec3 v) { return v.x + v.y + v.z < 40 ? 1.f : 0.f; };
  const double k = auto_extinction(make_field({{0, 0, 0}, {127, 127, 127}}, corner));
  EXPECT_TRUE(k > 3 / 40.0 && k < 3.0) << k;
}

TEST(AutoExtinction, IsOneWhereNothingIs) {
  EXPECT_EQ(auto_extinction(make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3) { return 0.f; })), 1);
  EXPECT_EQ(auto_extinction(Field{}), 1);
}

TEST(MakeView, ResolvesEveryOptional) {
  const auto field = std::make_shared<const Field>(
      make_field({{0, 0, 0}, {15, 15, 15}}, [](glm::ivec3) { return 1.f; }));
  const View cells = make_view(Scene{}, field, nullptr);
  EXPECT_EQ(cells.scene.grid, "density");
  EXPECT_EQ(cells.scene.extinction, 3 / 16.0);
  EXPECT_EQ(cells.medium.extinction, 3 / 16.0);
  EXPECT_EQ(cells.scene.integrator, Integrator::psi_weighted);
  EXPECT_EQ(cells.scene.sampling, Sampling::cells);
  EXPECT_EQ(cells.scene.step, std::nullopt);
  EXPECT_EQ(cells.scene.camera_position, cells.camera.position);
  EXPECT_EQ(cells.scene.camera_target, cells.camera.target);
  EXPECT_EQ(cells.scene.fov, horizontal_fov(Scene{}));
  EXPECT_EQ(cells.scene.ortho_width, std::nullopt);
  EXPECT_EQ(cells.medium.source, LuminanceSource::constant);

  Scene flat;
  flat.sampling = Sampling::uniform;
  flat.projection = Projection::orthographic;
  const View uniform = make_view(flat, field, nullptr);
  EXPECT_EQ(uniform.scene.step, 1.0);
  EXPECT_EQ(uniform.scene.integrator, Integrator::psi_balanced);
  EXPECT_EQ(uniform.scene.ortho_width, 2 * uniform.camera.half_width);

  // Rendering the resolved scene changes nothing.
  for (const View* view : {&cells, &uniform}) {
    const Scene read = scene_from_json(to_json(view->scene));
    EXPECT_EQ(to_json(make_view(read, field, nullptr).scene), to_json(view->scene));
  }
}

TEST(MakeView, ComponentsAttenuateByTheirMagnitude) {
  Field field = make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3 v) { return float(v.x) - 5; });
  field.of_vectors = true;
  Field magnitude =
      make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3 v) { return std::abs(float(v.x) - 5); });
  const auto component = share(std::move(field));
  Scene scene;
  scene.luminance = {1, 1, 1};
  for (const Mode mode : {Mode::alpha, Mode::xray}) {
    scene.mode = mode;
    const View view = make_view(scene, component, nullptr);
    ASSERT_TRUE(view.medium.transfer);
    EXPECT_FALSE(view.medium.transfer->has_color());
    for (const double value : {-5.0, -1.5, 0.0, 2.0})
      EXPECT_NEAR(view.medium.transfer->at(value).attenuation, std::abs(value), 1e-15);
    EXPECT_EQ(view.medium.source, LuminanceSource::constant);
    // both are linear between voxels, as 0 is at one
    EXPECT_NEAR(view.medium.extinction,
                make_view(scene, share(magnitude), nullptr).medium.extinction, 1e-12);
  }
}

TEST(MakeView, FindsWhereLuminanceComesFrom) {
  const Box box{{0, 0, 0}, {7, 7, 7}};
  const auto scalar = [&](const char* name) {
    Field field = make_field(box, [](glm::ivec3) { return 1.f; });
    field.name = name;
    return std::make_shared<const Field>(field);
  };
  Field colours = make_vector_field(box, [](glm::ivec3) { return glm::vec3(1, 2, 3); });
  colours.name = "Cd";
  const auto vector = std::make_shared<const Field>(colours);
  const auto density = scalar("density"), heat = scalar("heat");
  Scene scene;
  scene.luminance = {1, 2, 4};
  scene.luminance_scale = 3;
  EXPECT_EQ(make_view(scene, density, nullptr).medium.color, glm::dvec3(1, 2, 4));

  const View own = make_view(scene, density, density);
  EXPECT_EQ(own.medium.source, LuminanceSource::density);
  EXPECT_EQ(own.medium.luminance, nullptr);
  EXPECT_EQ(own.medium.color, glm::dvec3(3, 6, 12));
  EXPECT_EQ(own.scene.luminance_grid, "density");
  EXPECT_EQ(make_view(own.scene, density, nullptr).medium.source, LuminanceSource::density);

  const View other = make_view(scene, density, heat);
  EXPECT_EQ(other.medium.source, LuminanceSource::scalar);
  EXPECT_EQ(other.medium.luminance, heat);
  EXPECT_EQ(other.scene.luminance_grid, "heat");
  EXPECT_EQ(make_view(scene, density, vector).medium.source, LuminanceSource::vector);

  EXPECT_NE(input_error([&] { make_view(scene, vector, nullptr); }), "no error");
  EXPECT_NE(input_error([&] { make_view(scene, nullptr, nullptr); }), "no error");
}

}  // namespace
}  // namespace psivox
