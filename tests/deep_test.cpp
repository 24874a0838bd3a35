// Deep pictures: what their samples let through and show in front of every depth is within the
// tolerance, as "Interpreting OpenEXR Deep Pixels" reads them and as OpenImageIO does.

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "blobs_scene.h"
#include "march/march_double.h"
#include "psivox/draw.h"
#include "psivox/open.h"
#include "reference/ray_radiance.h"
#include "scratch.h"
#include "thrown.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

using Samples = std::vector<DeepSample>;

/// R, G, B and transmittance of the samples in front of z.
glm::dvec4 in_front(std::span<const DeepSample> samples, double z) {
  glm::dvec4 seen(0, 0, 0, 1);
  for (const DeepSample& s : samples) {
    if (z <= double(s.z)) break;
    const double x = std::min((z - double(s.z)) / (double(s.z_back) - double(s.z)), 1.0);
    const double a = double(s.a), part = -std::expm1(x * std::log1p(-a));
    seen += seen.w * (a > 0 ? part / a : x) * glm::dvec4(s.r, s.g, s.b, 0);
    seen.w *= 1 - part;
  }
  return seen;
}

double most(const glm::dvec4& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z), std::abs(v.w)});
}

/// No sample takes light away, and none is empty.
void expect_light(std::span<const DeepSample> samples) {
  for (const DeepSample& s : samples) {
    ASSERT_GE(std::min({s.r, s.g, s.b, s.a}), 0);
    ASSERT_GT(std::max({s.r, s.g, s.b, s.a}), 0);
  }
}

/// Samples of a curve from 0 to 1, and the greatest error at its points.
Samples fitted(const RayCurve& curve, double tolerance, double& error) {
  Samples samples;
  fit_samples(curve, tolerance, samples);
  expect_light(samples);
  error = 0;
  for (const CurvePoint& point : curve)
    error = std::max(error, most(in_front(samples, point.z) -
                                 glm::dvec4(point.radiance, std::exp(-point.depth))));
  return samples;
}

template <typename Depth>
RayCurve curve_of(const Depth& depth, double L) {
  RayCurve curve;
  for (int i = 0; i <= 1000; ++i) {
    const double z = i / 1000.0;
    curve.push_back({z, depth(z), glm::dvec3(L * -std::expm1(-depth(z)))});
  }
  return curve;
}

constexpr double rounding = 1e-6;  // samples are float32

TEST(DeepFit, AHomogeneousMediumIsOneSample) {
  double error = 0;
  const Samples samples = fitted(curve_of([](double z) { return 3 * z; }, 0.7), 1e-3, error);
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_LE(error, 1e-3);
}

TEST(DeepFit, NothingIsNoSample) {
  double error = 0;
  EXPECT_TRUE(fitted(curve_of([](double) { return 0.0; }, 1), 1e-3, error).empty());
  EXPECT_TRUE(fitted(curve_of([](double z) { return 8e-4 * z; }, 1), 1e-3, error).empty());
  EXPECT_LE(error, 1e-3);
}

/// A line beside a parabola of second derivative 2D may be off by E to both sides: it reaches
/// sqrt(8 E / D) far, so that sqrt(D / (8 E)) lines are enough where T is 1.
TEST(DeepFit, ALinearAttenuationTakesAsFewAsLinesBesideAParabola) {
  for (const double E : {1e-2, 1e-3, 1e-4}) {
    constexpr double D = 0.1;
    double error = 0;
    const Samples samples = fitted(curve_of([](double z) { return D * z * z; }, 1), E, error);
    EXPECT_LE(error, E + rounding);
    EXPECT_LE(double(samples.size()), std::ceil(std::sqrt(D / (8 * E))) + 1) << E;
  }
}

/// The point up to which one line, begun anywhere within the tolerance, follows the optical depths
/// from `first` on: the least that any sample could do better.
std::size_t longest_line(const RayCurve& curve, std::size_t first, double E) {
  const auto room = [&](double slope, std::size_t last) {  // for the line's begin
    double low = -1e300, high = 1e300;
    for (std::size_t i = first; i <= last; ++i) {
      const double T = std::exp(-curve[i].depth), rise = slope * (curve[i].z - curve[first].z);
      low = std::max(low, -std::log(T + E) - rise);
      if (T > E) high = std::min(high, -std::log(T - E) - rise);
    }
    return high - low;  // concave in the slope
  };
  std::size_t last = first + 1, end = curve.size() - 1;
  while (last < end) {
    const std::size_t middle = (last + end + 1) / 2;
    double a = 0, b = 100;
    for (int i = 0; i < 80; ++i) {
      const double p = a + (b - a) / 3, q = b - (b - a) / 3;
      (room(p, middle) < room(q, middle) ? a : b) = room(p, middle) < room(q, middle) ? p : q;
    }
    if (room(a, middle) >= 0)
      last = middle;
    else
      end = middle - 1;
  }
  return last;
}

/// Lines that need not meet are fewer than any samples can be.
TEST(DeepFit, TakesFewSamplesMoreThanTheLeastPossible) {
  std::size_t taken = 0, least = 0;
  for (int seed = 1; seed <= 12; ++seed) {
    RayCurve curve{{}};
    for (int i = 1; i <= 400; ++i) {  // smooth, positive attenuation of all scales
      double tau = 0;
      for (const int k : {1, 2, 3, 5, 8, 13})
        tau += std::pow(std::sin(k * (i / 130.0 + seed) + seed * seed), 2) / k;
      const double depth = curve.back().depth + 0.002 * seed * tau;
      curve.push_back({i / 400.0, depth, glm::dvec3(-std::expm1(-depth))});
    }
    double error = 0;
    taken += fitted(curve, 1e-3, error).size();
    EXPECT_LE(error, 1e-3 + rounding);
    for (std::size_t at = 0; at + 1 < curve.size() && std::exp(-curve[at].depth) > 1e-3; ++least)
      at = longest_line(curve, at, 1e-3);
  }
  // 150 and 136; the rounding of a sample takes 1/16 of the tolerance
  EXPECT_LE(double(taken), 1.15 * double(least));
}

TEST(DeepFit, GapsAndWallsStayWithinTheTolerance) {
  const auto depth = [](double z) {
    const double first = std::clamp(z - 0.2, 0.0, 0.1) * 5, wall = z > 0.7 ? 30 : 0;
    return first + wall + 3 * std::pow(std::max(z - 0.5, 0.0), 3);
  };
  double error = 0;
  const Samples samples = fitted(curve_of(depth, 2), 1e-3, error);
  EXPECT_LE(error, 1e-3 + rounding);
  EXPECT_LE(samples.size(), 8u);
  for (const DeepSample& s : samples) EXPECT_LT(s.a, 1);  // 1 would stand at the sample's front
}

TEST(DeepFit, AGlowWithoutOpacityGrowsLinearly) {
  RayCurve curve;
  for (int i = 0; i <= 100; ++i) curve.push_back({i / 100.0, 0, glm::dvec3(i / 50.0, 0, 0)});
  double error = 0;
  const Samples samples = fitted(curve, 1e-3, error);
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples.front().a, 0);
  EXPECT_LE(error, 1e-3);
}

/// Light of one colour that ends where another's begins: the first channel's fit is above its
/// curve.
TEST(DeepFit, AChannelThatHasEndedTakesNothingBack) {
  for (const double E : {1e-2, 1e-3, 1e-4}) {
    RayCurve curve{{}};
    for (int i = 1; i <= 1000; ++i) {
      const double z = i / 1000.0, depth = 4 * z * z * (3 - 2 * z);
      const double light = std::exp(-curve.back().depth) * -std::expm1(curve.back().depth - depth);
      glm::dvec3 radiance = curve.back().radiance;
      radiance[std::min(i / 300, 2)] += light;
      curve.push_back({z, depth, radiance});
    }
    double error = 0;
    fitted(curve, E, error);
    EXPECT_LE(error, E + rounding);
  }
}

class DeepPicture : public ::testing::Test {
 protected:
  static std::string path(const std::string& name) { return (test::scratch_dir() / name).string(); }

  static Scene scene(double tolerance = 1e-3) {
    Scene result = blobs_scene();
    result.sampling.reset();
    result.early_termination.reset();
    result.tolerance = tolerance;
    return result;
  }
  static Drawn drawn(const Scene& scene, bool deep = true) {
    Session session(scene);
    Wish wish;
    wish.layers.deep = deep;
    wish.exact = !deep;
    return session.draw(*open_double(), wish);
  }
  std::string written(const Image& image, const std::string& name) const {
    write_image(image, path(name));
    return path(name);
  }
  OIIO::ImageBuf deep(const Image& image, const std::string& name) const {
    OIIO::ImageBuf result(written(image, name));
    EXPECT_TRUE(result.read(0, 0, true)) << result.geterror();
    EXPECT_TRUE(result.deep());
    return result;
  }

  /// The greatest difference over R G B A of a deep picture, flattened, from another.
  static double difference(const OIIO::ImageBuf& deep, const Image& flat) {
    const OIIO::ImageBuf one = OIIO::ImageBufAlgo::flatten(deep);
    EXPECT_FALSE(one.has_error()) << one.geterror();
    const char* const names[] = {"R", "G", "B", "A"};
    double greatest = 0;
    for (int y = 0; y < flat.height; ++y)
      for (int x = 0; x < flat.width; ++x)
        for (int c = 0; c < 4; ++c) {
          const float value = one.getchannel(x, y, 0, one.spec().channelindex(names[c]));
          const std::size_t at = 4 * (std::size_t(y) * std::size_t(flat.width) + std::size_t(x));
          greatest = std::max(greatest, double(std::abs(value - flat.rgba()[at + std::size_t(c)])));
        }
    return greatest;
  }
};

/// The reference integrates each ray up to depths between those of the samples.
void expect_reference(Scene scene, double tolerance) {
  scene.resolution = {32, 24};
  Session session(scene);
  Wish wish;
  wish.layers.deep = true;
  const Drawn drawn = session.draw(*open_double(), wish);
  const DeepPixels& deep = drawn.image.deep;
  const View& view = drawn.view;
  const RayMedium medium(view.medium);
  RayIntegrator exact(medium, 1e-9);
  double greatest = 0;
  std::size_t at = 0, pixel = 0;
  const glm::ivec2 size = scene.resolution;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) {
      const std::span<const DeepSample> samples(deep.samples.data() + at, deep.counts[pixel]);
      at += deep.counts[pixel++];
      expect_light(samples);
      if ((x + 3 * y) % 7 || samples.empty()) continue;
      const WorldRay ray = camera_ray(view.camera, size, x + 0.5, y + 0.5);
      const double along = glm::dot(ray.direction, view.camera.forward);
      const double front = double(samples.front().z), back = double(samples.back().z_back);
      for (int i = 0; i <= 20; ++i) {
        const double z = front + (back - front) * (i / 18.0 - 0.05);
        const RayRadiance r = exact.radiance(ray, 0, z / along);
        greatest = std::max(greatest, most(in_front(samples, z) -
                                           glm::dvec4(r.radiance, std::exp(-r.optical_depth))));
      }
    }
  EXPECT_LE(greatest, tolerance);
  EXPECT_GT(greatest, tolerance / 4);  // or there are more samples than need be
}

TEST_F(DeepPicture, IsWithinTheToleranceOfTheReferenceAtEveryDepth) {
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    SCOPED_TRACE(tolerance);
    Scene shone = scene(tolerance);
    expect_reference(shone, tolerance);
    shone.projection = Projection::orthographic;
    shone.luminance_grid = "density";
    expect_reference(shone, tolerance);
    shone.luminance_grid.clear();
    shone.colormap = Colormap::viridis;
    expect_reference(shone, tolerance);
    shone.colormap.reset();
    shone.temperature_grid = "temperature";
    shone.emission_grid = "density";
    expect_reference(shone, tolerance);
  }
  Scene lit = scene(1e-3);
  lit.lights = {{{1, -2, -0.5}, {3, 2, 1}}};
  lit.sky = glm::dvec3(0.1, 0.2, 0.3);
  lit.albedo = {0.9, 0.8, 0.5};
  lit.phase_g = 0.6;
  expect_reference(lit, 1e-3);  // in the same light
}

TEST_F(DeepPicture, FlattensToTheFlatPicture) {
  for (const int samples : {1, 4}) {
    Scene one = scene();
    one.pixel_samples = samples;
    const Drawn flat = drawn(one, false);
    const Drawn made = drawn(one);
    EXPECT_LE(compare_images(made.image, flat.image).max, 1e-3);
    const OIIO::ImageBuf whole = deep(made.image, "whole.exr");
    EXPECT_LE(difference(whole, flat.image), 1e-3);
    EXPECT_LE(difference(whole, made.image), rounding);
  }
}

TEST_F(DeepPicture, HalvesMergeToTheWhole) {
  Scene front = scene();
  keep_camera(front, Session(front).view().camera);
  Scene back = front;
  front.clip_plane = Plane{{0.3, -0.2, 0.9}, glm::dvec3(0.1, 0.2, 0.05)};
  back.clip_plane = Plane{{-0.3, 0.2, -0.9}, glm::dvec3(0.1, 0.2, 0.05)};
  const OIIO::ImageBuf merged = OIIO::ImageBufAlgo::deep_merge(
      deep(drawn(front).image, "front.exr"), deep(drawn(back).image, "back.exr"));
  ASSERT_FALSE(merged.has_error()) << merged.geterror();
  front.clip_plane.reset();
  EXPECT_LE(difference(merged, drawn(front, false).image), 2e-3);  // of both halves
}

/// A deep holdout of opaque samples at the depths that --holdout reads.
TEST_F(DeepPicture, IsHeldOutAsByDepths) {
  Scene whole = scene();
  keep_camera(whole, Session(whole).view().camera);
  const Camera camera = Session(whole).view().camera;
  // between faces of voxels: OpenImageIO 2.4 keeps samples that begin at the very depth
  const float wall = float(glm::length(camera.target - camera.position)) + 0.0123f;
  const auto pixels = std::size_t(whole.resolution.x) * std::size_t(whole.resolution.y);
  Image opaque = rgba_image(whole.resolution.x, whole.resolution.y);
  opaque.layers.push_back({"Z", {"Z"}, std::vector<float>(pixels, wall)});
  Scene held = whole;
  held.holdout = written(opaque, "depths.exr");
  opaque.deep.counts.assign(pixels, 1);
  opaque.deep.samples.assign(pixels, {wall, wall, 0, 0, 0, 1});
  OIIO::ImageBuf mask(written(opaque, "mask.exr"));
  ASSERT_TRUE(mask.read(0, 0, true));
  const OIIO::ImageBuf rest =
      OIIO::ImageBufAlgo::deep_holdout(deep(drawn(whole).image, "whole.exr"), mask);
  ASSERT_FALSE(rest.has_error()) << rest.geterror();
  const Image flat = drawn(held, false).image;
  EXPECT_LE(difference(rest, flat), 1e-3);
  EXPECT_LE(difference(deep(drawn(held).image, "held.exr"), flat), 1e-3);
}

TEST_F(DeepPicture, RefusesInOneLine) {
  const auto refused = [&](const Scene& scene, const std::vector<std::string>& layers = {"deep"}) {
    return usage_error([&] { check_picture(scene, layers); });
  };
  for (const Mode mode :
       {Mode::mip, Mode::isosurface, Mode::xray, Mode::slice, Mode::back_to_front}) {
    Scene other = scene();
    other.mode = mode;
    EXPECT_TRUE(has(refused(other), "--aov deep"));
  }
  Scene other = scene();
  other.background = glm::dvec3(1);
  EXPECT_TRUE(has(refused(other), "--background"));
  other = scene();
  other.renderer = RendererKind::reference;
  EXPECT_TRUE(has(refused(other), "--renderer reference"));
  EXPECT_TRUE(has(refused(scene(), {"deep", "depth"}), "leave out the others"));
  Scene parts = scene();
  parts.memory_limit = 100000;
  EXPECT_THROW(drawn(parts), Error);
  const Image image = drawn(scene()).image;
  EXPECT_TRUE(
      has(usage_error([&] { write_image(image, path("a.exr"), {.half = true}); }), "--half"));
  EXPECT_THROW(read_image(written(image, "deep.exr")), Error);
}

}  // namespace
}  // namespace psivox
