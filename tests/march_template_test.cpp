// Ray templates: the list of voxels, and pictures made along it.

#include <glm/gtc/matrix_transform.hpp>

#include "march/march_tables.h"
#include "march_cases.h"

namespace psivox {
namespace {

const std::vector<glm::dvec3> directions{{0.3, -0.2, -1}, {1, 0.999, 0.5}, {-0.1, 1, 0.7},
                                         {0, 0, -1},      {1, 1, 1},       {1e-15, -2, 1e-15}};

TEST(RayTemplate, NeighboursShareWhatTheConnectivityAsks) {
  for (const glm::dvec3& direction : directions)
    for (const int connectivity : {6, 18, 26}) {
      const RayTemplate made = make_ray_template(direction, 100, connectivity);
      const double most = connectivity == 26 ? 3 : connectivity == 18 ? 2 : 1;
      for (std::size_t k = 1; k < made.entries.size(); ++k) {
        const glm::dvec3 move = glm::dvec3(made.entries[k]) - glm::dvec3(made.entries[k - 1]);
        const glm::dvec3 size = glm::abs(move);
        EXPECT_LE(std::max({size.x, size.y, size.z}), 1);
        EXPECT_GE(size.x + size.y + size.z, 1);
        EXPECT_LE(size.x + size.y + size.z, most);
        EXPECT_GT(made.entries[k].w, made.entries[k - 1].w);
      }
    }
}

TEST(RayTemplate, StaysWithinHalfAVoxelOfTheLine) {
  for (const glm::dvec3& direction : directions) {
    const RayTemplate made = make_ray_template(direction, 100, 26);
    ASSERT_EQ(made.entries.size(), 101u);  // one voxel per plane
    const double main = std::abs(direction[made.axis]);
    for (std::size_t k = 0; k < made.entries.size(); ++k) {
      const glm::dvec3 line = direction * (double(k) / main);
      const glm::dvec3 off = glm::abs(glm::dvec3(made.entries[k]) - line);
      // half a voxel across the main axis, and the rounding of a hundred additions
      EXPECT_LE(std::max({off.x, off.y, off.z}), 0.5 + 1e-9);
    }
  }
}

TEST(RayTemplate, SixConnectedVoxelsAreThoseThatTheLinePierces) {
  const glm::dvec3 direction(0.3, -0.2, -1);
  const RayTemplate made = make_ray_template(direction, 50, 6);
  // 50 planes, and the faces crossed on the way: 15 along x, 10 along y
  EXPECT_EQ(made.entries.size(), 1u + 50 + 15 + 10);
  for (const glm::vec4& entry : made.entries) {
    // the line passes through the voxel: some t is within half a voxel along every axis
    double first = -HUGE_VAL, last = HUGE_VAL;
    for (int i = 0; i < 3; ++i) {
      const double a = (entry[i] - 0.5) / direction[i], b = (entry[i] + 0.5) / direction[i];
      first = std::max(first, std::min(a, b));
      last = std::min(last, std::max(a, b));
    }
    EXPECT_LE(first, last + 1e-9);
  }
}

class MarchTemplate : public GpuTest {
 protected:
  /// An orthographic view of the blobs along `direction`, with their own value as luminance.
  static View view_along(const glm::dvec3& direction, int connectivity, Glow glow = Glow::density) {
    const glm::dvec3 middle(19.5, 17.5, 15.5);
    Scene scene = looking(small_scene(48), middle - 200.0 * direction, middle, 48.0);
    scene.camera_up = glm::dvec3(0.1, 1, 0.05);
    scene.sampling = Sampling::template_;
    scene.connectivity = connectivity;
    scene.integrator = Integrator::psi_exact;
    scene.extinction = 0.2;
    return view_of(scene, blobs(), glow);
  }
};

TEST_F(MarchTemplate, GpuIsTheMarchInDouble) {
  for (const glm::dvec3& direction : {glm::dvec3(0.31, -0.22, -1.0), glm::dvec3(-1, 0.4, 0.7)})
    for (const int connectivity : {6, 18, 26}) {
      const View view = view_along(glm::normalize(direction), connectivity);
      const Image gpu = gl_picture(view), wide = double_picture(view);
      expect_content(gpu);
      const Comparison c = difference("connectivity " + std::to_string(connectivity), gpu, wide);
      // float32: psi_exact's weights carry 2e-6 of the opacity. (No pixel of these views is close
      // enough to the middle of two base voxels to select the other one in float32.)
      EXPECT_LE(c.max, 4e-6);
    }
}

TEST_F(MarchTemplate, AlongAnAxisThroughVoxelsIsTheReference) {
  // Rays pass through voxel centres. Between these the field is linear, as the rule assumes, and L
  // tau is exactly a product of linear functions.
  Scene scene = looking(small_scene(40), {19.5, 17.5, 200}, {19.5, 17.5, 0}, 40.0);
  scene.sampling = Sampling::template_;
  scene.integrator = Integrator::psi_exact;
  scene.extinction = 0.2;
  const View view = view_of(scene, blobs(), Glow::density);
  const Image gpu = gl_picture(view);
  expect_content(gpu);
  // psi_exact's weights carry 2e-6 of the opacity in float32
  EXPECT_LE(difference("along z", gpu, render_reference(view).image).max, 4e-6);
}

// A ray that enters through a face other than the base plane's meets the domain behind the plane.
// Samples are within half a voxel of their ray along each axis, so the picture is off by less than
// it changes if the camera moves by one voxel.
TEST_F(MarchTemplate, RaysEnterThroughEveryFace) {
  for (const glm::dvec3& direction : {glm::dvec3(-0.9, -0.5, -1), {0.8, 0.9, 1}, {-1, 0.7, 0.6}}) {
    const View view = view_along(glm::normalize(direction), 26, Glow::constant);
    View moved = view;
    moved.camera.position += moved.camera.right;
    const Image image = gl_picture(view), reference = render_reference(view).image;
    expect_content(image);
    const double voxel = difference("moved", render_reference(moved).image, reference).rms;
    EXPECT_LE(difference("oblique", image, reference).rms, voxel);
    EXPECT_NEAR(mean_alpha(image) / mean_alpha(reference), 1, 0.02);
  }
}

TEST_F(MarchTemplate, OneVoxelASampleIsOneFetch) {
  const View view = view_along(glm::normalize(glm::dvec3(0.3, -0.2, -1)), 26);
  const RenderResult gpu = render_gl(view, build_medium_atlas(view), {.render = {.count = true}});
  // at most 34 planes of voxels with their tents
  EXPECT_GT(gpu.stats.samples, 0u);
  EXPECT_LE(gpu.stats.samples, 48u * 48u * 40u);
}

TEST_F(MarchTemplate, SecondGridsMustShareTheVoxels) {
  Scene scene = looking(small_scene(8), {0, 0, 100}, {0, 0, 0}, 48.0);
  scene.sampling = Sampling::template_;
  const View view =
      view_of(scene, blobs(), blobs({0, 0, 0}, glm::scale(glm::dmat4(1), glm::dvec3(0.5))));
  EXPECT_THROW(check_sampling(view), Error);
}

}  // namespace
}  // namespace psivox
