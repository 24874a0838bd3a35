// Light of a latitude-longitude map, and albedos that differ by place: against a sky, a light,
// closed forms and the reference.

#include "scene/environment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/ext/scalar_constants.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "march_cases.h"
#include "psivox/draw.h"
#include "psivox/picture_file.h"
#include "scratch.h"
#include "thrown.h"

namespace psivox {
namespace {

constexpr double pi = glm::pi<double>();
using Radiance = std::function<glm::vec3(int x, int y)>;

std::vector<glm::vec3> pixels(const glm::ivec2& size, const Radiance& radiance) {
  std::vector<glm::vec3> all;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) all.push_back(radiance(x, y));
  return all;
}

/// A sky, ground, a broad glow and a sun of a pixel.
glm::vec3 weather(int x, int y) {
  const float u = (float(x) + 0.5f) / 64, v = (float(y) + 0.5f) / 32;
  glm::vec3 L = v < 0.5f ? glm::vec3(0.25f, 0.4f, 0.8f) * (1.2f - v) : glm::vec3(0.2f, 0.15f, 0.1f);
  L += glm::vec3(1.5f, 1.1f, 0.7f) *
       std::exp(-40 * ((u - 0.3f) * (u - 0.3f) + (v - 0.3f) * (v - 0.3f)));
  return x == 20 && y == 8 ? glm::vec3(900, 800, 650) : L;
}

/// A map as a file.
std::string map_file(const std::string& name, const glm::ivec2& size, const Radiance& radiance) {
  Image image{size.x, size.y, {{"", {"R", "G", "B", "A"}, {}}}, {}};
  for (const glm::vec3& L : pixels(size, radiance))
    image.layers.front().values.insert(image.layers.front().values.end(), {L.x, L.y, L.z, 1});
  const auto path = test::scratch_dir() / (name + ".exr");
  write_image(image, path);
  return path.string();
}

/// The blobs at a quarter of their size.
Field small_blobs() {
  return make_field({{0, 0, 0}, {10, 9, 8}},
                    [](glm::ivec3 v) { return blobs_at(4.0 * glm::dvec3(v)); });
}

Scene environment_scene() {
  Scene scene;
  scene.resolution = {48, 36};
  scene.extinction = 0.3;
  return scene;
}

TEST(Environment, LooksWhereBlenderAndOpenExrLook) {
  // one bright pixel, left of the middle and above it
  const glm::ivec2 size(64, 32);
  const auto spot =
      pixels(size, [](int x, int y) { return glm::vec3(x == 16 && y == 10 ? 1 : 0); });
  const double longitude = pi * (1 - 2 * 16.5 / 64), height = pi * (0.5 - 10.5 / 32);
  const double across = std::cos(height);
  const glm::dvec3 z_up(across * std::cos(longitude), across * std::sin(longitude),
                        std::sin(height));
  const glm::dvec3 y_up(across * std::sin(longitude), std::sin(height),
                        across * std::cos(longitude));
  const auto brightest = [](const Environment& map) { return map.sources(1).front().towards; };
  // the sum over a pixel lies on its middle meridian, at the middle of its light
  const double half = pi / 64;
  EXPECT_LT(glm::distance(brightest({size, spot, true, 0}), z_up), half * half);
  EXPECT_LT(glm::distance(brightest({size, spot, false, 0}), y_up), half * half);
  const Environment turned(size, spot, true, pi / 2);
  EXPECT_LT(glm::distance(brightest(turned), {-z_up.y, z_up.x, z_up.z}), half * half);
  for (const bool up : {true, false}) {
    const Environment map(size, spot, up, 0.7);
    EXPECT_NEAR(map.at(brightest(map)).x, 1, 0.01);
    EXPECT_EQ(map.at(-brightest(map)).x, 0);
  }
}

TEST(Environment, SourcesHaveAllLightAndTheSunAlone) {
  const Environment map({64, 32}, pixels({64, 32}, weather), false, 0);
  glm::dvec3 all(0);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x)
      all +=
          glm::dvec3(weather(x, y)) * (std::cos(pi * y / 32) - std::cos(pi * (y + 1) / 32)) / 128.0;
  const double of_sun = 900 * (std::cos(pi * 8 / 32) - std::cos(pi * 9 / 32)) / 128;
  for (const int count : {8, 32, 512}) {
    glm::dvec3 sum(0);
    double greatest = 0;
    const auto sources = map.sources(count);
    EXPECT_LE(int(sources.size()), count);
    for (const auto& source : sources) {
      sum += source.radiance;
      greatest = std::max(greatest, source.radiance.x);
    }
    // rounding of sums over 10^5 cells
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], all[c], 1e-10);
    // few parts leave the sun's pixel whole, which then has less than a mean part beside it
    if (count > 32) continue;
    EXPECT_GT(greatest, 0.99 * of_sun);
    EXPECT_LT(greatest, of_sun + all.x / count);
  }
}

// A sum over directions, each with the part of its light that a face along an axis lets through, as
// a dense medium's does: its horizon is a plane along axes, as the sides of a map's rectangles are.
TEST(Environment, FacesAlongAxesHaveNoCommonError) {
  const Environment map(
      {64, 32}, pixels({64, 32}, [](int x, int) { return glm::vec3(1 + 1e-6f * float(x)); }), false,
      0);
  const auto sources = map.sources(512);
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      double sum = 0;
      for (const auto& source : sources)
        sum += source.radiance.x * std::max(sign * source.towards[axis], 0.0);
      // the mean of max(cos, 0) over the sphere; rectangles about the map's own axis are off by
      // 2.3e-3 of it
      EXPECT_NEAR(sum, 0.25, 0.25 * 1e-3) << axis << ' ' << sign;
    }
}

TEST(Environment, DarkPartsAreNoSources) {
  const auto spot = pixels({64, 32}, [](int x, int y) { return glm::vec3(x == 9 && y == 9); });
  const Environment map({64, 32}, spot, true, 0.3);
  for (const auto& source : map.sources(1024)) {
    EXPECT_TRUE(std::isfinite(source.towards.x));
    EXPECT_GT(map.at(source.towards).x, 0);
  }
}

using EnvironmentTest = GpuTest;

Image drawn(const Scene& scene, const Field& density) {
  return Session(view_of(scene, density)).draw(*Gpu::renderer()).image;
}

TEST_F(EnvironmentTest, AConstantMapIsASky) {
  Scene scene = environment_scene();
  scene.albedo = {0.5, 0.9, 0.7};
  scene.tolerance = 1e-3;
  Scene with_sky = scene;
  with_sky.sky = glm::dvec3(0.5, 0.25, 1);
  scene.environment = map_file("constant", {16, 8}, [](int, int) { return glm::vec3(1, 0.5f, 2); });
  scene.environment_scale = 0.5;
  scene.environment_rotation = 33;
  const Image image = drawn(scene, small_blobs());
  expect_content(image);
  EXPECT_EQ(compare_images(image, drawn(with_sky, small_blobs())).max, 0);
}

TEST_F(EnvironmentTest, ASunIsALight) {
  // all light in one pixel, which is divided into 8 x 8 cells
  Scene scene = environment_scene();
  scene.light_quality = LightQuality::exact;
  scene.sampling = Sampling::cells;
  Scene with_light = scene;
  const glm::ivec2 size(2048, 1024);
  const auto sun = [](int x, int y) { return glm::vec3(x == 300 && y == 200 ? 1e5f : 0); };
  scene.environment = map_file("sun", size, sun);
  const double u = 300.5 / 2048, v = 200.5 / 1024, across = std::sin(pi * v);
  const double longitude = pi * (1 - 2 * u);
  const glm::dvec3 towards(across * std::sin(longitude), std::cos(pi * v),
                           across * std::cos(longitude));
  const double share = (std::cos(pi * 200 / 1024) - std::cos(pi * 201 / 1024)) / (2.0 * 2048);
  with_light.lights = {{-towards, glm::dvec3(1e5 * share)}};
  const Image image = drawn(scene, small_blobs());
  expect_content(image);
  // float32 pictures of at most 0.5
  EXPECT_LE(compare_images(image, drawn(with_light, small_blobs())).max, 1e-6);
}

TEST_F(EnvironmentTest, AToleranceHoldsAgainstTheReference) {
  struct Case {
    const char* name;
    Scene scene;
    std::vector<std::shared_ptr<const Field>> albedo{};
  };
  Scene scene = environment_scene();
  scene.environment = map_file("weather", {64, 32}, weather);
  const auto noisy = [](int x, int y) {
    return 4.0f * glm::vec3(noise({x, y, 0}), noise({x, y, 1}), noise({x, y, 2}));
  };
  Scene turned = scene, lit = scene;
  turned.environment = map_file("noise", {64, 32}, noisy);
  turned.environment_rotation = 100;
  turned.up_axis = UpAxis::z;
  lit.lights = {{{1, -1, -1}, {0.5, 0.3, 0.2}}};
  lit.luminance = glm::dvec3(0.1);
  lit.phase_g = 0.5;
  const auto colors = share(make_vector_field(
      {{0, 0, 0}, {9, 8, 7}},
      [](glm::ivec3 v) { return glm::vec3(float(v.x) / 9, 1 - float(v.y) / 8, 0.5f); },
      glm::scale(glm::dmat4(1), glm::dvec3(2.2))));
  const Case cases[] = {
      {"weather", scene}, {"noise, turned", turned}, {"a light, colours, forward", lit, {colors}}};
  const auto reference = open_reference();
  for (const Case& one : cases) {
    const auto view = [&](std::optional<double> tolerance) {
      Scene asked = one.scene;
      asked.tolerance = tolerance;
      MediumFields fields{share(small_blobs()), nullptr, nullptr};
      fields.albedo = one.albedo;
      return make_view(asked, fields);
    };
    const Image truth = Session(view({})).draw(*reference).image;
    expect_content(truth);
    for (const double E : {1e-2, 1e-4}) {
      const Drawn picture = Session(view(E)).draw(*Gpu::renderer());
      const double rms = compare_images(picture.image, truth).rms;
      const double estimate = picture.plan->chosen.rms;
      std::printf("  %-20s %.0e: rms %.2f E, estimate %.2f E, %d beams by %s\n", one.name, E,
                  rms / E, estimate / E, picture.light->beams, picture.light->method.c_str());
      EXPECT_LE(rms, E) << one.name;
      // the estimate is of a sample of rays and of the quadrature's error by a law
      EXPECT_GE(estimate, rms / 3) << one.name << ' ' << E;
    }
  }
}

TEST_F(EnvironmentTest, StandsBehindTheVolumeIfAsked) {
  Scene scene = environment_scene();
  scene.environment = map_file("behind", {64, 32}, weather);
  scene.background = Background{};
  scene.background->environment = true;
  Session session(view_of(scene, small_blobs()));
  Image image = session.draw(*Gpu::renderer()).image;
  const Image before = image;
  const View& view = session.view();
  add_background(image, scene.background->color, legend_of(view).behind);
  for (int x = 0; x < 48; x += 7) {
    const glm::dvec3 L =
        view.environment->at(camera_ray(view.camera, {48, 36}, x + 0.5, 9.5).direction);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(pixel(image, x, 9, c),
                  pixel(before, x, 9, c) + (1 - pixel(before, x, 9, 3)) * L[c], 1e-6 * (1 + L[c]));
  }
}

TEST_F(EnvironmentTest, BadMapsAreRefused) {
  const auto says = [](const std::string& file, const char* words) {
    Scene scene = environment_scene();
    scene.environment = file;
    EXPECT_TRUE(has(input_error([&] { drawn(scene, small_blobs()); }), words));
  };
  says("none.hdr", "none.hdr");
  says(map_file("square", {8, 8}, [](int, int) { return glm::vec3(1); }), "twice as wide as high");
  says(map_file("black", {8, 4}, [](int, int) { return glm::vec3(0); }), "black");
  says(map_file(
           "inf", {8, 4},
           [](int x, int) { return glm::vec3(x ? 1 : std::numeric_limits<float>::infinity()); }),
       "NaN or Inf");
}

// --- an albedo that differs by place -------------------------------------------------------------

/// A slab under a light straight from above, seen from above: at the optical depth t its luminance
/// is a(t) e^-t, seen through e^-t.
constexpr double slab_K = 0.1, slab_D = 16 * slab_K;

/// The pixel in the middle of a picture of it.
glm::dvec3 seen_slab(std::vector<std::shared_ptr<const Field>> albedo, double value) {
  Scene scene;
  scene.resolution = {5, 5};
  scene.extinction = slab_K / value;
  scene.lights = {{{0, 0, -1}, glm::dvec3(1)}};
  scene.tolerance = 1e-4;
  scene = looking(scene, {0, 0, 60}, {0, 0, 7.5}, 4);
  MediumFields fields{
      share(make_field({{-16, -16, 0}, {15, 15, 15}}, [&](glm::ivec3) { return float(value); })),
      nullptr, nullptr};
  fields.albedo = std::move(albedo);
  const Image image = Session(make_view(scene, fields)).draw(*Gpu::renderer()).image;
  return {pixel(image, 2, 2, 0), pixel(image, 2, 2, 1), pixel(image, 2, 2, 2)};
}

TEST_F(EnvironmentTest, AColouredSlabIsItsClosedForm) {
  // Integral of (p + q t) e^-2t from 0 to D: the albedo is linear in the depth.
  const auto closed = [](double p, double q) {
    const double e = std::exp(-2 * slab_D);
    return p * (1 - e) / 2 + q * ((1 - e) / 4 - slab_D * e / 2);
  };
  const auto color = [](int z) {
    const float t = float(slab_K * (15.5 - z));
    return glm::vec3(0.2f + 0.5f * t, 0.9f - 0.5f * t, 0.6f);
  };
  const glm::dvec3 exact(closed(0.2, 0.5), closed(0.9, -0.5), closed(0.6, 0));
  // beside the tolerance: e^-t is interpolated between voxels, K^2 / 8 of it; the rim, where the
  // density falls to 0 within two voxels, has the colour's end and e^-t of K / 2 around it
  const double bound = 1e-4 + slab_K * slab_K / 2;
  const Box box{{-16, -16, -1}, {15, 15, 16}};
  const auto vectors = share(make_vector_field(box, [&](glm::ivec3 v) { return color(v.z); }));
  const auto part = [&](int c, float density) {
    return share(make_field({{-16, -16, 0}, {15, 15, 15}},
                            [=](glm::ivec3 v) { return density * color(v.z)[c]; }));
  };
  const glm::dvec3 of_vectors = seen_slab({vectors}, 1);
  const glm::dvec3 of_parts = seen_slab({part(0, 0.4f), part(1, 0.4f), part(2, 0.4f)}, 0.4f);
  const glm::dvec3 grey = seen_slab({part(2, 1)}, 1);
  std::printf("  slab %.5f %.5f %.5f, exact %.5f %.5f %.5f, parts %.5f\n", of_vectors.x,
              of_vectors.y, of_vectors.z, exact.x, exact.y, exact.z, of_parts.x);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(of_vectors[c], exact[c], bound);
    EXPECT_NEAR(of_parts[c], exact[c], bound);
  }
  EXPECT_EQ(grey.x, grey.y);
  EXPECT_NEAR(seen_slab({}, 1).x, closed(1, 0), bound);
}

}  // namespace
}  // namespace psivox
