// One medium, given in different ways, gives one picture; and rays along faces, edges and corners.
// `psivox verify`, which verify_test runs, has shifts, turns, tiles, far origins and scales.

#include <gtest/gtest.h>

#include <string>

#include "march_cases.h"

namespace psivox {
namespace {

class MarchInvariance : public GpuTest {};

/// The bound for both samplings, with L from the grid.
void expect_same(const std::string& what, const Image& a, const Image& b, double tolerance = 1e-5) {
  expect_content(a);
  EXPECT_LE(difference(what, a, b).max, tolerance) << what;
}

TEST_F(MarchInvariance, EmptyBricksAreNextToNothing) {
  // A block that ends at bricks' faces, beside empty bricks and beside bricks that hold 1e-9:
  // segments that end behind its face count in full. Rays leave through the upper faces, where the
  // block's last cells belong to its own bricks.
  const auto block = [](float elsewhere) {
    return make_field({glm::ivec3(0), glm::ivec3(39)}, [=](glm::ivec3 v) {
      const bool in = glm::all(glm::greaterThanEqual(v, glm::ivec3(8))) &&
                      glm::all(glm::lessThan(v, glm::ivec3(24)));
      // varied, because constant runs have their own steps
      return (in ? 1.0f : elsewhere) * (1 + 0.1f * float((v.x + 2 * v.y + 3 * v.z) & 7));
    });
  };
  for (const Integrator rule :
       {Integrator::midpoint, Integrator::porter_duff, Integrator::psi_balanced})
    for (const double step : {0.9, 5.0}) {
      const Scene scene =
          looking(with(small_scene(48, 0.15), rule, step), {-60, -40, -50}, {16, 16, 16});
      const View empty = view_of(scene, block(0), Glow::density);
      const View filled = view_of(scene, block(1e-9f), Glow::density);
      const std::string what = std::string(info(rule).name) + ", step " + std::to_string(step);
      expect_same(what, gl_picture(filled), gl_picture(empty));
      expect_same(what + ", in double", double_picture(filled), double_picture(empty));
    }
}

TEST_F(MarchInvariance, AnyAffineTransformIsTheReference) {
  // Rotated, anisotropic and sheared; with constant L, cells have no step error.
  const Field field = make_field(
      {{0, 0, 0}, {39, 35, 31}}, [](glm::ivec3 v) { return blobs_at(glm::dvec3(v)); }, sheared);
  const auto shared = share(field);
  const glm::dvec3 middle(sheared * glm::dvec4(20, 18, 16, 1));
  for (const glm::dvec3& from : {glm::dvec3(50, 20, 30), {-60, 5, -20}, {0, 3, 0.5}}) {
    Scene scene = looking(small_scene(), middle + from, middle);
    scene.extinction = 0.4;
    scene.camera_up = glm::dvec3(0.3, 0.2, 1);
    const View view = view_of(scene, shared);
    expect_same("sheared", render_reference(view).image, gl_picture(view),
                1e-6 * quotient_errors());
  }
}

TEST_F(MarchInvariance, ValuesNearTheLeastFloatKeepTheirLight) {
  const Box box{{0, 0, 0}, {39, 35, 31}};
  const auto light =
      share(make_field(box, [](glm::ivec3 v) { return 1 + blobs_at(glm::dvec3(v)); }));
  const auto picture = [&](float scale) {
    Scene scene = looking(small_scene(), {60, 30, 50}, {20, 18, 16});
    scene.integrator = Integrator::cell_exact;
    scene.extinction = 0.4 / double(scale);
    const auto density = [&](glm::ivec3 v) { return scale * blobs_at(glm::dvec3(v)); };
    return gl_picture(make_view(scene, share(make_field(box, density)), light));
  };
  // the values themselves are rounded, by 2^-24 each
  expect_same("values of 1e-31", picture(1), picture(1e-31f), 2e-6);
}

// float32 places a ray within 16 * 2^-24 = 1e-6 voxels, and noise has a slope of 1 per voxel, with
// the same sign along all 24 of them: 24 * 0.1 * 1e-6 of optical depth.
constexpr double along_faces = 2.4e-6;

TEST_F(MarchInvariance, RaysAlongFacesEdgesAndCorners) {
  // Orthographic, pixel centres exactly on voxel coordinates: 33 pixels over 33 voxels, the middle
  // one through the target. Axes run along edges; diagonals of faces and of the cube run through
  // corners.
  const auto field = share(make_field({{0, 0, 0}, {23, 23, 23}}, noise));
  const glm::dvec3 middle(12, 12, 12);
  const glm::dvec3 directions[] = {{1, 0, 0},  {0, 1, 0}, {0, 0, -1}, {1, 1, 0}, {-1, 0, 1},
                                   {0, 1, -1}, {1, 1, 1}, {-1, 1, 1}, {2, 1, 0}};
  for (const glm::dvec3& d : directions)
    for (const bool odd : {true, false}) {  // pixel centres on voxels, or midway between them
      Scene scene =
          looking(small_scene(odd ? 33 : 32), middle - 40.0 * d, middle, odd ? 33.0 : 32.0);
      scene.camera_up = d.x == 0 && d.z == 0 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
      scene.extinction = 0.1;
      const View view = view_of(scene, field);
      const std::string what =
          "along " + std::to_string(int(d.x)) + std::to_string(int(d.y)) + std::to_string(int(d.z));
      expect_same(what, render_reference(view).image, gl_picture(view),
                  along_faces * quotient_errors());
      scene.step = 0.7;
      const View uniform = view_of(scene, field, Glow::density);
      EXPECT_LE(difference(what + " uniform", gl_picture(uniform), double_picture(uniform)).max,
                2e-5);
    }
}

TEST_F(MarchInvariance, CameraOnVoxelsAndFaces) {
  const auto field = share(make_field({{0, 0, 0}, {23, 23, 23}}, noise));
  for (const glm::dvec3& at : {glm::dvec3(12, 12, 12), {8, 12, 12}, {12.5, 8, 16}, {-1, 3, 3}}) {
    Scene scene = looking(small_scene(33), at, at + glm::dvec3(1, 0.25, 0.5));
    scene.fov = 110;
    scene.extinction = 0.1;
    const View view = view_of(scene, field);
    expect_same("camera inside", render_reference(view).image, gl_picture(view),
                along_faces * quotient_errors());
  }
}

}  // namespace
}  // namespace psivox
