// The layers of a picture (depth, transmittance, steps and look-ups), and the mean of several
// samples per pixel.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "field_voxels.h"
#include "march_cases.h"
#include "plan/plan.h"
#include "reference/ray_radiance.h"

namespace psivox {
namespace {

class MarchLayers : public GpuTest {};

Scene across_plate(int side = 40) { return oblique(side, 0.3); }

TEST_F(MarchLayers, DepthIsWhereHalfTheLightIsLeft) {
  // A plate of 0.25 from x = 0 on: optical depth 0.125 in the ramp, then 0.25 per unit, divided by
  // cos.
  const Field plate = make_field({{0, -40, -40}, {30, 40, 40}}, [](glm::ivec3) { return 0.25f; });
  for (const double width : {0.0, 30.0})
    for (const std::optional<double> step : {std::optional<double>{}, std::optional<double>(0.5)}) {
      Scene scene = looking(small_scene(24), {-37, 4, 3}, {0, 0, 0},
                            width > 0 ? std::optional(width) : std::nullopt);
      scene.extinction = 1;
      scene.step = step;
      const View view = view_of(scene, plate);
      const MediumAtlas atlases = build_medium_atlas(view);
      const RenderResult gpu = render_gl(view, atlases, {.render = all_layers});
      const RenderResult wide = render_double(view, atlases, all_layers);
      for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 24; ++x) {
          const auto i = std::size_t(y * 24 + x);
          const WorldRay ray = pixel_ray(view, x, y);
          const double cosine = ray.direction.x;
          const double inside = (std::numbers::ln2 * cosine - 0.125) / 0.25;  // along x, from x = 0
          const double expected = (inside - ray.origin.x) / cosine;
          // A step of the lattice may contain parts of the ramp and of the plate.
          const double tolerance = step ? 0.05 : 1e-4;
          EXPECT_NEAR(layer(gpu.image, "depth").values[i], expected, tolerance) << x << ' ' << y;
          EXPECT_NEAR(layer(gpu.image, "depth").values[i], layer(wide.image, "depth").values[i],
                      1e-4);
        }
    }
}

TEST_F(MarchLayers, DepthIsInsideARampsCell) {
  // attenuation rises from 0 at x = 3 to 1 at x = 4: K (x - 3)^2 / 2 = ln 2
  const Field slab = make_field({{4, -8, -8}, {9, 8, 8}}, [](glm::ivec3) { return 1.0f; });
  for (const double K : {2.0, 5.0, 20.0, 200.0})
    for (const Integrator rule : {Integrator::cell_exact, Integrator::psi_weighted}) {
      Scene scene = with(looking(small_scene(4), {-10, 0.3, 0.4}, {0, 0.3, 0.4}, 2.0), rule, {});
      scene.extinction = K;
      const View view = view_of(scene, slab);
      const MediumAtlas atlases = build_medium_atlas(view);
      const double expected = 13 + std::sqrt(2 * std::numbers::ln2 / K);
      for (const RenderResult& drawn : {render_gl(view, atlases, {.render = all_layers}),
                                        render_double(view, atlases, all_layers)})
        EXPECT_NEAR(layer(drawn.image, "depth").values[5], expected, 1e-5)  // float32 at 13: 1e-6
            << info(rule).name << ' ' << K;
    }
}

TEST_F(MarchLayers, DepthIsInfiniteWhereMostLightGoesThrough) {
  Scene scene = across_plate();
  const View view = view_of(scene, mixed());
  const Image image = render_gl(view, build_medium_atlas(view), {.render = all_layers}).image;
  std::size_t near = 0, far = 0;
  for (std::size_t i = 0; i < 1600; ++i) {
    const float depth = layer(image, "depth").values[i];
    const float alpha = image.rgba()[4 * i + 3];
    if (std::abs(alpha - 0.5f) < 1e-5f) continue;
    EXPECT_EQ(std::isinf(depth), alpha < 0.5f) << i;
    (std::isinf(depth) ? far : near) += 1;
  }
  EXPECT_GT(near, 100u);
  EXPECT_GT(far, 100u);
}

TEST_F(MarchLayers, TransmittanceIsWhatOpacityLeaves) {
  for (const std::optional<double> step : {std::optional<double>{}, std::optional<double>(1.0)}) {
    Scene scene = across_plate();
    scene.step = step;
    const View view = view_of(scene, mixed(), Glow::density);
    const Image image = render_gl(view, build_medium_atlas(view), {.render = all_layers}).image;
    for (std::size_t i = 0; i < 1600; ++i)
      EXPECT_NEAR(layer(image, "transmittance").values[i] + image.rgba()[4 * i + 3], 1, 2e-7);
  }
}

TEST_F(MarchLayers, RaysThatAreNotDrawnAreThoseOfTheMarch) {
  // The volume is in a corner of the picture; the GPU draws only there.
  for (const Mode mode : {Mode::alpha, Mode::mip, Mode::isosurface, Mode::back_to_front})
    for (const int samples : {1, 3}) {
      Scene scene = looking(small_scene(64), {95, 60, 70}, {11, 52, -29});
      scene.mode = mode;
      if (mode == Mode::isosurface) scene.isovalue = {{0.2}};
      scene.pixel_samples = samples;
      scene.extinction = 0.3;
      const View view = view_of(scene, mixed());
      const MediumAtlas atlases = build_medium_atlas(view);
      const Image drawn = render_gl(view, atlases, {.render = all_layers}).image;
      const Image wide = render_double(view, atlases, all_layers).image;
      const glm::dvec3 low(atlases.density.domain.min), high(atlases.density.domain.max);
      const std::vector<PixelBox> missed = around(pixels_of(view, low, high), {{}, {64, 64}});
      int pixels = 0;
      for (const PixelBox& box : missed)
        for (int y = box.origin.y; y < box.origin.y + box.size.y; ++y)
          for (int x = box.origin.x; x < box.origin.x + box.size.x; ++x, ++pixels)
            for (std::size_t k = 0; k < drawn.layers.size(); ++k) {
              const std::size_t channels = drawn.layers[k].channels.size();
              for (std::size_t c = 0; c < channels; ++c) {
                const std::size_t at = std::size_t(y * 64 + x) * channels + c;
                EXPECT_EQ(drawn.layers[k].values[at], wide.layers[k].values[at])
                    << drawn.layers[k].name << ' ' << x << ' ' << y;
              }
            }
      EXPECT_GT(pixels, 1000);
      expect_content(drawn, 0.01);
    }
}

TEST_F(MarchLayers, LayersAreThoseAskedFor) {
  const View view = view_of(across_plate(), mixed());
  const MediumAtlas atlases = build_medium_atlas(view);
  EXPECT_EQ(render_gl(view, atlases).image.layers.size(), 1u);
  const Image plain = render_gl(view, atlases).image;
  const RenderResult counted = render_gl(view, atlases, {.render = all_layers});
  std::set<std::string> names;
  for (const Layer& l : counted.image.layers) names.insert(l.name);
  EXPECT_EQ(names, (std::set<std::string>{"", "depth", "transmittance", "steps", "samples"}));
  EXPECT_EQ(difference("with and without layers", plain, counted.image).max, 0);
}

// --- several samples a pixel ---------------------------------------------------------------------

TEST_F(MarchLayers, PixelSamplesAreTheMeanOfTheirRays) {
  for (const int n : {2, 5, 16}) {
    Scene scene = across_plate(20);
    scene.pixel_samples = n;
    const View view = view_of(scene, mixed());
    const RenderResult gpu = render_gl(view, build_medium_atlas(view), {.render = all_layers});
    EXPECT_EQ(gpu.stats.rays, 400u * std::uint64_t(n));
    double worst = 0;
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 20; ++x) {
        double mean = 0;
        for (int i = 0; i < n; ++i) {
          const glm::dvec2 at = glm::dvec2(x, y) + pixel_sample(i, n);
          const WorldRay ray = camera_ray(view.camera, scene.resolution, at.x, at.y);
          mean -= std::expm1(-ray_radiance(view.medium, ray).optical_depth) / n;
        }
        worst = std::max(worst, std::abs(pixel(gpu.image, x, y, 3) - mean));
      }
    std::printf("  %d samples: %.2e\n", n, worst);
    EXPECT_LE(worst, 1e-6);
    EXPECT_LE(difference("march in double", gpu.image, double_picture(view)).max, 2e-5);
  }
}

// --- counts --------------------------------------------------------------------------------------

/// Whether one of the values of 4^3 cells is not 0.
bool holds_any(const FieldVoxels& voxels, const glm::ivec3& octant) {
  bool any = false;
  for_points({4 * octant, 4 * octant + 4},
             [&](const glm::ivec3& v) { any |= voxels(v) != glm::vec3(0); });
  return any;
}

/// Counts the cells that the picture's rays cross in bricks whose values differ, but for octants of
/// zeros. It sorts the crossings of each ray with all faces and takes their middles; it shares no
/// code with the march.
std::uint64_t cells_crossed(const View& view) {
  const Field& field = *view.medium.density;
  const FieldVoxels voxels(field);
  const PlainField plain_field(field);
  std::unordered_map<std::uint64_t, bool> textured;
  std::uint64_t cells = 0;
  const Box domain = field.domain();
  for (int y = 0; y < view.scene.resolution.y; ++y)
    for (int x = 0; x < view.scene.resolution.x; ++x) {
      const WorldRay ray = pixel_ray(view, x, y);
      std::vector<double> faces{0};
      plain_field.add_faces(ray, 0, 1e9, faces);
      std::sort(faces.begin(), faces.end());
      for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
        const glm::dvec3 p =
            plain_field.index_at(ray.origin + 0.5 * (faces[i] + faces[i + 1]) * ray.direction);
        const glm::ivec3 cell(glm::floor(p));
        if (glm::any(glm::lessThan(cell, domain.min)) ||
            glm::any(glm::greaterThanEqual(cell, domain.max)))
          continue;
        const glm::ivec3 octant = cell >> 2;
        const auto part = [](int v) { return std::uint64_t(v + (1 << 20)); };
        const std::uint64_t key = part(octant.x) << 42 | part(octant.y) << 21 | part(octant.z);
        auto found = textured.find(key);
        if (found == textured.end())
          found = textured
                      .emplace(key, voxels.kind(octant >> 1) == EntryKind::brick &&
                                        holds_any(voxels, octant))
                      .first;
        cells += found->second;
      }
    }
  return cells;
}

/// `begins`: rays that may start inside a brick; none on real files seen from outside.
void expect_look_ups(const std::string& what, const View& view, std::uint64_t begins) {
  const RenderResult gpu = render_gl(view, build_medium_atlas(view), {.render = all_layers});
  const std::uint64_t cells = cells_crossed(view);
  const double ratio = double(gpu.stats.samples) / double(cells);
  std::printf("  %-16s look-ups %.2f a ray, cells crossed %.2f, ratio %.5f\n", what.c_str(),
              double(gpu.stats.samples) / double(gpu.stats.rays),
              double(cells) / double(gpu.stats.rays), ratio);
  testing::Test::RecordProperty(what, std::to_string(ratio));
  EXPECT_GT(cells, 1000u) << what;
  // At most one more look-up finds the value at a ray's start, if that is in a brick.
  EXPECT_GE(ratio, 0.98) << what;
  EXPECT_LE(double(gpu.stats.samples), 1.02 * double(cells) + double(begins)) << what;
  // Rays along faces read the cells on one side or the other.
  const std::uint64_t wide =
      render_double(view, build_medium_atlas(view), all_layers).stats.samples;
  EXPECT_NEAR(double(wide) / double(gpu.stats.samples), 1, 0.005);
}

TEST_F(MarchLayers, LookUpsAreTheCellsCrossed) {
  Scene inside = looking(small_scene(24), {12.3, 9.1, 10.7}, {-20, 14, 2});
  const auto field = share(mixed());
  expect_look_ups("outside", view_of(across_plate(32), field), 1024);
  expect_look_ups("L from grid", view_of(across_plate(32), field, Glow::density), 1024);
  expect_look_ups("inside", view_of(inside, field), 576);
  expect_look_ups("orthographic",
                  view_of(looking(small_scene(32), {95, 60, 70}, {11, 12, 11}, 60.0), field), 1024);
}

TEST_F(MarchLayers, StepsAreSegments) {
  // Along x through a rod of 20 voxels: 21 cells, each with as many segments as asked for. Under
  // uniform sampling: the 21 units in steps of 1/4 from the lattice, which is anchored at the
  // domain's middle.
  const auto rod = share(make_field({{0, 0, 0}, {19, 2, 2}}, noise));
  for (const int segments : {1, 2, 3}) {
    Scene scene = looking(small_scene(4), {-30, 1.1, 0.9}, {0, 1.1, 0.9}, 1.0);
    scene.segments = segments;
    const View view = view_of(scene, rod, Glow::density);
    const Image image = render_gl(view, build_medium_atlas(view), {.render = all_layers}).image;
    for (const float steps : layer(image, "steps").values)
      EXPECT_LE(steps, 21.0f * float(segments));
    for (const float steps : layer(image, "steps").values)
      EXPECT_GE(steps, 15.0f * float(segments));
  }
}

/// The better picture of layer `error` shares the errors of an exactly marched one. A few hundred
/// rays of the reference measure them.
TEST_F(MarchLayers, TheErrorLayerHoldsWhatBothPicturesShare) {
  for (const Glow glow : {Glow::constant, Glow::density}) {
    View view = exact_view(view_of(across_plate(96), mixed(), glow));
    const MediumAtlas atlas = build_medium_atlas(view);
    const Image picture = render_gl(view, atlas).image;
    const CheckedError left = exact_error(view, render_gl(pilot_view(view), atlas).image);
    const Layer error = error_layer(picture, picture, {}, left.rms);
    const double layer_rms = double(error.values.front());  // the same everywhere
    const double rms = difference("reference", picture, render_reference(view).image).rms;
    EXPECT_GT(rms, 1e-9);
    // the estimate uses 800 of 9216 pixels
    EXPECT_LT(layer_rms, 2 * rms);
    EXPECT_GT(layer_rms, rms / 2);
  }
}

}  // namespace
}  // namespace psivox
