#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "reference/ray_radiance.h"
#include "reference/reference.h"
#include "reference_cases.h"

namespace psivox {
namespace {

View view_of(Mode mode, Field density, double extinction = 1) {
  View view;
  view.scene.mode = mode;
  view.medium = make_medium(std::move(density), extinction, LuminanceSource::constant);
  return view;
}

RayPicture picture(const View& view, const WorldRay& ray) {
  const RayMedium medium(view.medium);
  return RayModes(view, medium, 1e-12).picture(ray, std::numeric_limits<double>::infinity());
}

/// The density's value at t, and the t of its faces in order, from the domain's first to its last.
struct Profile {
  Profile(const View& view, const WorldRay& world_ray, double t1)
      : field(*view.medium.density), ray(world_ray) {
    field.add_faces(ray, 0, t1, faces);
    if (field.in_domain(ray.origin)) faces.push_back(0);
    std::sort(faces.begin(), faces.end());
    std::erase_if(faces, [&](double t) { return !inside(t + 1e-9) && !inside(t - 1e-9); });
  }
  bool inside(double t) const { return field.in_domain(ray.origin + t * ray.direction); }
  double operator()(double t) const { return field.value(ray.origin + t * ray.direction).x; }

  /// The greatest value in [a, b], which contains one maximum.
  double peak(double a, double b) const {
    for (int i = 0; i < 100; ++i) {
      const double u = a + (b - a) / 3, v = b - (b - a) / 3;
      ((*this)(u) < (*this)(v) ? a : b) = (*this)(u) < (*this)(v) ? u : v;
    }
    return (*this)(0.5 * (a + b));
  }

  PlainField field;
  WorldRay ray;
  std::vector<double> faces;
};

/// Takes 200 samples between neighbouring faces: the first maximum that is at least the threshold,
/// otherwise the greatest value.
double plain_maximum(const Profile& value, double threshold) {
  double greatest = 0;
  std::vector<double> t;
  for (std::size_t k = 0; k + 1 < value.faces.size(); ++k)
    for (int i = 0; i < 200; ++i)
      t.push_back(value.faces[k] + (value.faces[k + 1] - value.faces[k]) * (i + 1e-9) / 200);
  if (t.empty()) return 0;
  t.push_back(value.faces.back() - 1e-12);
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double before = t[i > 0 ? i - 1 : i], after = t[std::min(i + 1, t.size() - 1)];
    if (value(before) > value(t[i]) || value(after) > value(t[i])) continue;
    const double here = std::max(value.peak(before, t[i]), value.peak(t[i], after));
    greatest = std::max(greatest, here);
    if (greatest >= threshold && value(after) < greatest) break;
  }
  return greatest;
}

TEST(ReferenceModes, BackToFrontIsTheSamePicture) {
  View view = view_of(Mode::alpha, make_field({{0, 0, 0}, {15, 15, 15}}, noise), 0.4);
  view.medium.source = LuminanceSource::density;
  View other = view;
  other.scene.mode = Mode::back_to_front;
  for (const WorldRay& ray : rays_through({0, 0, 0}, {15, 15, 15}, 20)) {
    const RayRadiance r = ray_radiance(view.medium, ray);
    for (const View* v : {&view, &other}) {
      const RayPicture p = picture(*v, ray);
      EXPECT_EQ(p.radiance, r.radiance);
      EXPECT_EQ(p.opacity, -std::expm1(-r.optical_depth));
      EXPECT_EQ(p.error, r.error);
      EXPECT_EQ(p.cells, r.cells);
    }
  }
}

TEST(ReferenceModes, XrayIsTheOpticalDepth) {
  // 100 deep: in other modes a ray would end long before.
  View view = view_of(Mode::xray, make_field({{0, 0, 0}, {9, 9, 9}}, one), 10);
  view.medium.color = {1, 2, 3};
  const RayPicture p = picture(view, {{-5, 4.25, 3.5}, {1, 0, 0}});
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(p.radiance[c], 100 * (c + 1), 1e-12);
  EXPECT_EQ(p.opacity, 1);
  EXPECT_LT(p.error, 1e-10);
  // With a function: half of the ramps at both ends is above 1/2.
  view.medium.transfer = function({{0.5, 0, {}}, {1, 2, {}}});
  EXPECT_NEAR(picture(view, {{-5, 4.25, 3.5}, {1, 0, 0}}).radiance.x,
              10 * (2 * 9 + 2 * 0.5 * 0.5 * 2), 1e-12);
  EXPECT_EQ(picture(view, {{-5, 20, 3.5}, {1, 0, 0}}).opacity, 0);
}

TEST(ReferenceModes, MaximaAgreeWithSamples) {
  View view = view_of(Mode::mip, sheared_noise());
  view.medium.color = {1, 2, 0.5};
  View local = view;
  local.scene.mode = Mode::lmip;
  local.medium.least_value = 1e-12;  // rounding, in double
  local.scene.lmip_threshold = 0.3;
  int different = 0;
  for (const WorldRay& ray : sheared_rays(40)) {
    const Profile value(view, ray, 60);
    // A maximum is accurate to the square of its position's error, 1e-8; at a kink to 1e-9 of a
    // cell.
    const RayPicture p = picture(view, ray), q = picture(local, ray);
    EXPECT_NEAR(p.radiance.x, plain_maximum(value, 2), 1e-8);
    EXPECT_NEAR(q.radiance.x, plain_maximum(value, 0.3), 1e-8);
    different += p.radiance.x != q.radiance.x;
    EXPECT_EQ(p.radiance, glm::dvec3(1, 2, 0.5) * p.radiance.x);
    EXPECT_EQ(p.opacity, p.radiance.x > 0 ? 1 : 0);
    if (p.opacity > 0) {
      EXPECT_NEAR(value(p.depth), p.radiance.x, 1e-12);
    }
    if (q.opacity > 0) {
      EXPECT_NEAR(value(q.depth), q.radiance.x, 1e-12);
    }
    EXPECT_LT(p.error, 1e-14);
  }
  EXPECT_GT(different, 5);
}

TEST(ReferenceModes, ALocalMaximumIsNotAPlateau) {
  // 0.6 for 16 voxels, where rounding creates no maximum, then 0.9, then 1.
  View view = view_of(Mode::lmip, make_field({{0, 0, 0}, {31, 9, 9}}, [](glm::ivec3 v) {
                        return v.x < 16 ? 0.6f : v.x < 20 ? 0.9f : v.x < 24 ? 0.7f : 1.0f;
                      }));
  view.scene.lmip_threshold = 0.5;
  for (const double y : {3.0, 4.1, 5.77})
    EXPECT_EQ(picture(view, {{-5, y, 4.3}, {1, 0, 0}}).radiance.x, double(0.9f));
  view.scene.lmip_threshold = 0.95;
  EXPECT_EQ(picture(view, {{-5, 4.1, 4.3}, {1, 0, 0}}).radiance.x, 1);
  view.scene.lmip_threshold = 2;  // no maximum reaches it: the greatest value counts
  EXPECT_EQ(picture(view, {{-5, 4.1, 4.3}, {1, 0, 0}}).radiance.x, 1);
}

TEST(ReferenceModes, MaximaAreShownByTheFunction) {
  View view = view_of(Mode::mip, make_field({{0, 0, 0}, {9, 9, 9}},
                                            [](glm::ivec3 v) { return static_cast<float>(v.x); }));
  view.medium.color = {1, 2, 4};
  view.medium.transfer = function({{0, 0, {0, 0, 1}}, {4, 0, {1, 0, 1}}, {12, 1, {0, 1, 0}}});
  const WorldRay across{{4.5, -5, 4.5}, {0, 1, 0}}, below{{3.5, -5, 4.5}, {0, 1, 0}};
  EXPECT_EQ(picture(view, across).radiance, glm::dvec3(4.5, 9, 18));
  EXPECT_EQ(picture(view, below).opacity, 0);  // the attenuation of 3.5 is 0
  EXPECT_EQ(picture(view, below).radiance, glm::dvec3(0));
  view.medium.source = LuminanceSource::transfer;
  const glm::dvec3 color = picture(view, across).radiance;
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(color[c], (glm::dvec3(15, 1, 15) / 16.0 * glm::dvec3(1, 2, 4))[c], 1e-15);
}

TEST(ReferenceModes, LeastAndMeanValuesOfALine) {
  // x and 4 - x / 2 in turn, from 0 to 8: along x the mean is that of a line, and along z the
  // values alternate, so that the mean is that of both
  Field field = make_field({{0, 0, 0}, {8, 8, 8}}, [](glm::ivec3 v) {
    return v.z % 2 == 0 ? float(v.x) + 1 : 6 - 0.5f * float(v.x);
  });
  field.margin = 0;
  View view = view_of(Mode::minip, field);
  EXPECT_EQ(picture(view, {{-5, 4, 4}, {1, 0, 0}}).radiance.x, 1);
  EXPECT_NEAR(picture(view, {{-5, 4, 4}, {1, 0, 0}}).depth, 5, 1e-12);
  EXPECT_EQ(picture(view, {{-5, 4, 3}, {1, 0, 0}}).radiance.x, 2);
  EXPECT_EQ(picture(view, {{6, 4, -5}, {0, 0, 1}}).radiance.x, 3);
  view.scene.mode = Mode::mean;
  EXPECT_NEAR(picture(view, {{-5, 4, 4}, {1, 0, 0}}).radiance.x, 5, 1e-12);
  EXPECT_NEAR(picture(view, {{-5, 4, 3}, {1, 0, 0}}).radiance.x, 4, 1e-12);
  EXPECT_NEAR(picture(view, {{6, 4, -5}, {0, 0, 1}}).radiance.x, 5, 1e-12);
  EXPECT_TRUE(std::isinf(picture(view, {{6, 4, -5}, {0, 0, 1}}).depth));
  EXPECT_EQ(picture(view, {{6, 14, -5}, {0, 0, 1}}).opacity, 0);
}

TEST(ReferenceModes, TheEmptyDomainHasTheMaximumZero) {
  Field field = make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3) { return -1.0f; });
  field.active_box = {{0, 0, 0}, {40, 7, 7}};
  View view = view_of(Mode::mip, field);
  view.medium.transfer = function({{0, 1, {0.25, 1, 1}}});
  view.medium.source = LuminanceSource::transfer;
  EXPECT_EQ(picture(view, {{30, 4, -9}, {0, 0, 1}}).radiance, glm::dvec3(0.25, 1, 1));
  EXPECT_EQ(picture(view, {{42, 4, -9}, {0, 0, 1}}).opacity, 0);  // beside the domain
}

TEST(ReferenceModes, APlaneIsHitAndShadedExactly) {
  // A field that is linear in the world, which trilinear interpolation reproduces.
  const glm::dvec3 n = glm::normalize(glm::dvec3(1, 2, -0.5));
  const glm::dvec3 middle(sheared * glm::dvec4(8, 8, 8, 1));
  auto make = [&](double sign) {
    return make_field(
        {{0, 0, 0}, {16, 16, 16}},
        [&](glm::ivec3 v) {
          const glm::dvec3 world(sheared * glm::dvec4(glm::dvec3(v), 1));
          return static_cast<float>(5 + sign * glm::dot(n, world - middle));
        },
        sheared);
  };
  for (const double sign : {1.0, -1.0}) {
    View view = view_of(Mode::isosurface, make(sign));
    const glm::dvec3 color(1, 0.5, 2);
    view.medium.surfaces = {{5, color}};
    for (const glm::dvec3& direction : {glm::dvec3(1, 0, 0), {-0.3, 1, 0.2}, {0.1, 0.4, -1}}) {
      const glm::dvec3 d = glm::normalize(direction);
      const double facing = std::abs(glm::dot(n, d));
      view.scene.lights.clear();
      // starts inside the domain, because the domain's faces may be surfaces
      const RayPicture p = picture(view, {middle - 0.5 * d, d});
      // Values are rounded to float32: 3e-7, over a slope of `facing`; the gradient over 0.3 to 1.1
      // units, for a transform whose columns are nearly orthogonal.
      EXPECT_NEAR(p.depth, 0.5, 1e-6 / facing);
      EXPECT_EQ(p.opacity, 1);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(p.radiance[c], color[c] * (0.2 + 0.8 * facing), 2e-5);
      EXPECT_LT(p.error, 1e-11);
      const double side = glm::dot(n, d) > 0 ? -1 : 1;  // the normal faces the camera
      for (const glm::dvec3& light : {glm::dvec3(0, -2, 0), glm::dvec3(1, 1, 3)}) {
        view.scene.lights = {{light, {1, 1, 1}}};
        const double lit = std::max(0.0, -side * glm::dot(n, glm::normalize(light)));
        EXPECT_NEAR(picture(view, {middle - 0.5 * d, d}).radiance.x, 0.2 + 0.8 * lit, 2e-5);
        // a second light adds its own colour
        view.scene.lights.push_back({d, {0, 0, 0.5}});
        const glm::dvec3 both = picture(view, {middle - 0.5 * d, d}).radiance;
        EXPECT_NEAR(both.x, 0.2 + 0.8 * lit, 2e-5);
        EXPECT_NEAR(both.z, 2 * (0.2 + 0.8 * (lit + 0.5 * facing)), 4e-5);
      }
    }
  }
}

TEST(ReferenceModes, NormalsOfASphereErrBySecondOrder) {
  const glm::dvec3 middle(0.3, 0.1, -0.2);
  for (const double R : {8.0, 16.0}) {
    const int wide = int(R) + 4;
    View view = view_of(Mode::isosurface,
                        make_field({glm::ivec3(-wide), glm::ivec3(wide)}, [&](glm::ivec3 v) {
                          return float(glm::length(glm::dvec3(v) - middle) - R);
                        }));
    view.medium.surfaces = {{0}};
    double most = 0;
    for (int i = 0; i < 200; ++i) {
      const double z = (2 * i + 1) / 200.0 - 1, turn = 2.4 * i;
      const double r = std::sqrt(1 - z * z);
      const glm::dvec3 out(r * std::cos(turn), r * std::sin(turn), z);
      const glm::dvec3 side = glm::normalize(glm::cross(out, glm::dvec3(0.6, 0, 0.8)));
      for (const double sign : {1.0, -1.0}) {  // a light from 45 degrees beside the normal
        const glm::dvec3 light = glm::normalize(sign * side - out);
        view.scene.lights = {{light, {1, 1, 1}}};
        const double lit = picture(view, {middle + (R + 1.5) * out, -out}).radiance.x;
        most = std::max(most, std::abs((lit - 0.2) / 0.8 + glm::dot(out, light)));
      }
    }
    std::printf("  radius %g: off by up to %.1e\n", R, most);
    // Third derivatives of a distance are at most 1.2 / r^2 along an axis and their sum over the
    // axes 2 / r^2. A difference over two voxels misses a sixth of the first, and trilinear
    // interpolation an eighth of the second; r >= R - 1, and three components add up. The gradient
    // of a cell would be off by 0.5 / R.
    EXPECT_LE(most, std::sqrt(3.0) * 0.45 / ((R - 1) * (R - 1)));
    EXPECT_GT(most, 0);
  }
}

TEST(ReferenceModes, SurfacesAreCompositedFromTheFront) {
  View view = view_of(Mode::isosurface,
                      make_field({{0, 0, 0}, {9, 9, 9}}, [](glm::ivec3 v) { return float(v.x); }));
  view.medium.surfaces = {{2.5, {1, 0, 0}, 0.25}, {4.5, {0, 1, 0}, 0.5}, {6.5, {0, 0, 1}}};
  const RayPicture p = picture(view, {{0.5, 4, 4}, {1, 0, 0}});  // each faces the ray
  EXPECT_EQ(p.radiance, glm::dvec3(0.25, 0.75 * 0.5, 0.75 * 0.5));
  EXPECT_EQ(p.opacity, 1);
  EXPECT_NEAR(p.depth, 4, 1e-12);  // 0.375 is left behind the second
  const RayPicture q = picture(view, {{5.5, 4, 4}, {-1, 0, 0}});
  EXPECT_EQ(q.radiance, glm::dvec3(0.5 * 0.25, 0.5, 0));
  EXPECT_EQ(q.opacity, 1 - 0.5 * 0.75);
  EXPECT_TRUE(std::isinf(picture(view, {{3.5, 4, 4}, {-1, 0, 0}}).depth));
}

TEST(ReferenceModes, SurfacesAgreeWithSamples) {
  View view = view_of(Mode::isosurface, sheared_noise());
  for (const double isovalue : {0.2, 0.5, 0.8}) {
    view.medium.surfaces = {{isovalue}};
    int hits = 0;
    for (const WorldRay& ray : sheared_rays(40)) {
      const Profile value(view, ray, 60);
      std::vector<double> passages = value.faces;
      add_passages([&](double t) { return value(t); }, isovalue, passages, 200);
      passages.erase(passages.begin(), passages.begin() + std::ptrdiff_t(value.faces.size()));
      const RayPicture p = picture(view, ray);
      EXPECT_EQ(p.opacity, passages.empty() ? 0 : 1);
      if (passages.empty()) continue;
      const double first = *std::min_element(passages.begin(), passages.end());
      EXPECT_NEAR(p.depth, first, 1e-11);
      EXPECT_NEAR(value(p.depth), isovalue, 1e-12);
      ++hits;
    }
    EXPECT_GT(hits, 5) << isovalue;
  }
}

TEST(ReferenceModes, ASurfaceInAFaceIsHitOnce) {
  // Layers of 0, 1/2, 1: the surface lies exactly in the voxels' plane x = 3.
  View view = view_of(Mode::isosurface, make_field({{0, 0, 0}, {9, 9, 9}}, [](glm::ivec3 v) {
                        return v.x < 3 ? 0.0f : v.x == 3 ? 0.5f : 1.0f;
                      }));
  view.medium.surfaces = {{0.5}};
  for (const double y : {3.0, 4.1, 5.77})
    EXPECT_NEAR(picture(view, {{-5, y, 4.3}, {1, 0, 0}}).depth, 8, 1e-14);
  EXPECT_NEAR(picture(view, {{4.5, 4, 4.3}, {-1, 0, 0}}).depth, 1.5, 1e-14);
  EXPECT_EQ(picture(view, {{-5, 20, 4}, {1, 0, 0}}).opacity, 0);
}

TEST(ReferenceModes, PicturesOfSurfacesAndMaximaHaveDepth) {
  View view = view_of(Mode::isosurface, make_field({{0, 0, 0}, {9, 9, 9}}, one));
  view.medium.surfaces = {{0.5}};
  view.scene.resolution = {5, 5};
  view.scene.pixel_samples = 2;
  view.camera.position = {4.5, 4.5, 30};
  view.camera.right = {1, 0, 0};
  view.camera.up = {0, 1, 0};
  view.camera.forward = {0, 0, -1};
  view.camera.orthographic = true;
  view.camera.half_width = view.camera.half_height = 12;
  const Image image = render_reference(view).image;
  ASSERT_EQ(image.layers.size(), 3u);
  EXPECT_EQ(image.layers[2].name, "depth");
  EXPECT_FLOAT_EQ(image.layers[2].values[12], 20.5);
  EXPECT_TRUE(std::isinf(image.layers[2].values[0]));
  EXPECT_FLOAT_EQ(image.rgba()[4 * 12], 1);
  EXPECT_EQ(image.rgba()[4 * 12 + 3], 1);
  view.scene.mode = Mode::alpha;
  EXPECT_EQ(render_reference(view).image.layers.size(), 2u);
}

}  // namespace
}  // namespace psivox
