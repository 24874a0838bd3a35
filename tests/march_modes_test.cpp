// Modes other than alpha: compares the march in double with the reference, the GPU with the march
// in double, and the layer `depth` with the place that is seen.

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/vec3.hpp>
#include <string>

#include "march_cases.h"
#include "medium/map_field.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

const glm::dvec3 modes_eye(60, 70, 90), modes_middle(12, 11, 12);

Scene perspective() { return looking(small_scene(40), modes_eye, modes_middle); }
Scene parallel() { return looking(small_scene(40), modes_eye, modes_middle, 60); }

/// Vacuum below 1/2, then a ramp.
std::shared_ptr<const TransferFunction> ramp() {
  return function(
      {{0, 0, {1, 0, 0}}, {0.5, 0, {1, 0.4, 0}}, {0.75, 1, {0, 0.3, 1}}, {2, 1, {0, 1, 0}}});
}

View mode_view(const Scene& scene, Field field, Mode mode) {
  View view = view_of(scene, std::move(field));
  view.scene.mode = mode;
  view.scene.lmip_threshold = mode == Mode::lmip ? 0.45 : 0;
  view.medium.surfaces = {{0.4, {1, 0.5, 0.25}}};
  view.medium.least_value = 4e-6;  // the rounding of values up to 1
  view.medium.extinction = 0.1;
  view.medium.color = {1, 0.5, 0.25};
  return view;
}
View with_ramp(View view) {
  view.medium.transfer = ramp();
  view.medium.source = LuminanceSource::transfer;
  for (Surface& surface : view.medium.surfaces)
    surface.color *= view.medium.transfer->at(surface.isovalue).color;
  return view;
}

const char* mode_name(Mode mode) { return mode == Mode::isosurface ? "surface" : info(mode).name; }

/// Perspective without a function and parallel with one: these cover what the two can do wrong.
View either(bool parallel_with_function, Field field, Mode mode) {
  if (!parallel_with_function) return mode_view(perspective(), std::move(field), mode);
  return with_ramp(mode_view(parallel(), std::move(field), mode));
}
std::string what(Mode mode, bool parallel_with_function) {
  return std::string(mode_name(mode)) + (parallel_with_function ? ", parallel, function" : "");
}

const RenderOptions with_depth{.depth = true};
Image deep_double(const View& view) {
  return render_double(view, build_medium_atlas(view), with_depth).image;
}
Image deep_gpu(const View& view) {
  return render_gl(view, build_medium_atlas(view), {.render = with_depth}).image;
}

struct Probe {
  double distance = 0, value = 0;
};
/// A pixel's layer `depth`, and the field's value there.
Probe probe(const View& view, const Image& image, int x, int y) {
  static std::shared_ptr<const Field> last;
  static std::optional<PlainField> field;
  if (last != view.medium.density) field.emplace(*(last = view.medium.density));
  const double t = layer(image, "depth").values[std::size_t(y * image.width + x)];
  const WorldRay ray = pixel_ray(view, x, y);
  return {t, std::isinf(t) ? 0 : field->value(ray.origin + t * ray.direction).x};
}

/// Depths are infinite in the same pixels and otherwise agree within 1e-4 voxels. If the value
/// hardly changes along the ray, its rounding shifts the place further; then the values agree.
void expect_depth(const View& view, const Image& image, const Image& reference) {
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Probe a = probe(view, image, x, y), b = probe(view, reference, x, y);
      ASSERT_EQ(std::isinf(a.distance), std::isinf(b.distance)) << x << ',' << y;
      if (std::isinf(b.distance)) continue;
      EXPECT_TRUE(std::abs(a.distance - b.distance) <= 1e-4 || std::abs(a.value - b.value) <= 1e-5)
          << x << ',' << y << ": " << a.distance << " has " << a.value << ", not " << b.distance
          << " with " << b.value;
    }
}

/// The depth of every maximum is a place with that value; on a plateau any place will do. Depths
/// are float32 of 100 and more, 4e-6, and slopes are below 3.
void expect_maximum_there(const View& view, const Image& image) {
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Probe p = probe(view, image, x, y);
      ASSERT_EQ(std::isinf(p.distance), pixel(image, x, y, 3) == 0) << x << ',' << y;
      if (std::isinf(p.distance)) continue;
      ASSERT_NEAR(p.value * view.medium.color.x, pixel(image, x, y, 0), 5e-5) << x << ',' << y;
    }
}

/// The number of pixels that differ by more than `tolerance`, and the RMS of the others.
std::pair<int, double> outliers(const Image& a, const Image& b, double tolerance) {
  int count = 0;
  double sum = 0;
  const auto p = a.rgba(), q = b.rgba();
  for (std::size_t i = 0; i < p.size(); i += 4) {
    double most = 0, squares = 0;
    for (std::size_t c = i; c < i + 4; ++c) {
      const double d = double(p[c]) - double(q[c]);
      most = std::max(most, std::abs(d));
      squares += d * d;
    }
    if (most > tolerance)
      ++count;
    else
      sum += squares;
  }
  return {count, std::sqrt(sum / double(p.size()))};
}

class MarchModes : public GpuTest {};

TEST(MarchModesDouble, MaximaAreTheReference) {
  for (const Mode mode : {Mode::mip, Mode::lmip})
    for (const bool smooth : {false, true})
      for (const bool second : {false, true}) {
        const View view = either(second, smooth ? blobs() : mixed(), mode);
        const Image reference = render_reference(view).image, image = deep_double(view);
        expect_content(reference);
        // Both find the cubic's own maximum: only the picture's rounding to float32 remains.
        EXPECT_LE(difference(what(mode, second), image, reference).max, 1e-7);
        // the only plateau of blobs is vacuum, which is not visible
        if (smooth)
          expect_depth(view, image, reference);
        else if (!second)
          expect_maximum_there(view, image);
      }
}

TEST_F(MarchModes, MaximaOnTheGpuAreTheMarchInDouble) {
  for (const Mode mode : {Mode::mip, Mode::lmip})
    for (const bool second : {false, true}) {
      const View view = either(second, mixed(), mode);
      const Image gpu = deep_gpu(view);
      // Places are accurate to 1e-5 voxels, and values of noise there to that times its slope, 2;
      // the ramp multiplies that by four. In LMIP a ray that cuts a cell's corner may meet a fall
      // that is about as small as what counts as one (least_value).
      const auto [count, rms] = outliers(gpu, double_picture(view), 8e-5);
      std::printf("  %s: rms %.2e, %d pixels with another maximum\n", what(mode, second).c_str(),
                  rms, count);
      EXPECT_LE(rms, 1e-6);
      EXPECT_LE(count, mode == Mode::lmip ? 3 : 0);
      if (!second) expect_maximum_there(view, gpu);
    }
}

/// Without vacuum, whose 0 would be the least value of every ray.
Field cloudy() {
  Field field = make_field({{0, 0, 0}, {23, 21, 23}},
                           [](glm::ivec3 v) { return 0.55f + 0.4f * float(noise(v)); });
  field.margin = 0;
  return field;
}

TEST_F(MarchModes, LeastAndMeanValuesAreTheReference) {
  for (const Mode mode : {Mode::minip, Mode::mean})
    for (const bool second : {false, true}) {
      const View view = either(second, second || mode == Mode::minip ? cloudy() : mixed(), mode);
      const Image reference = render_reference(view).image, image = deep_double(view);
      expect_content(reference);
      EXPECT_LE(difference(what(mode, second), image, reference).max, 1e-7);
      if (mode == Mode::minip && !second) expect_depth(view, image, reference);
      // as of maxima; a mean of 40 cells gains the roundings of as many sums
      const auto [count, rms] = outliers(deep_gpu(view), image, 8e-5);
      EXPECT_LE(rms, 1e-6) << what(mode, second);
      EXPECT_EQ(count, 0) << what(mode, second);
    }
}

/// From -100 to 5 in a vacuum of 0, with more below 0.
Field hollows() {
  return make_field({{0, 0, 0}, {23, 21, 23}}, [](glm::ivec3 v) {
    const float depth = -100 * noise(v);
    return v.x > 14 && v.y < 7 ? 5 * noise(v) : v.z > 17 ? 0.0f : depth;
  });
}

/// As the program makes it: with the automatic range.
View program_view(Mode mode, Field field) {
  Scene scene = parallel();
  scene.mode = mode;
  if (mode == Mode::isosurface) scene.isovalue = {{-30}};
  return make_view(scene, share(std::move(field)), nullptr);
}

TEST_F(MarchModes, ValuesBelowZeroAreMaximaAndSurfacesToo) {
  // Where no value is above 0, the greatest is that of the vacuum, whatever rounding makes of it;
  // and a first maximum of at least 0 is none of rounding's either.
  for (const Mode mode : {Mode::mip, Mode::lmip, Mode::mean, Mode::isosurface}) {
    const View view = program_view(mode, hollows());
    const Image reference = render_reference(view).image;
    expect_content(reference);
    // of the range, which is 5 for maxima; a fall or a grazed corner that is about least_value may
    // count in one of the two, and normals of noise turn (see above)
    const auto [count, rms] = outliers(gl_picture(view), reference, 1e-4);
    std::printf("  %s below 0: rms %.2e, %d pixels off\n", mode_name(mode), rms, count);
    EXPECT_LE(rms, 1e-5);
    EXPECT_LE(count, 8);  // one pixel in 200
  }
}

TEST(MarchModesDouble, SurfacesAreTheReference) {
  for (const bool smooth : {false, true})
    for (const bool second : {false, true}) {
      const View view = either(second, smooth ? blobs() : mixed(), Mode::isosurface);
      const Image reference = render_reference(view).image, image = deep_double(view);
      expect_content(reference);
      // Roots are bisected to 2^-20 of a cell. A normal turns by that over the gradient's length,
      // which is as small as 0.01 where noise has a saddle.
      EXPECT_LE(difference(what(Mode::isosurface, second), image, reference).rms, 1e-6);
      expect_depth(view, image, reference);
    }
}

/// Places are accurate to 1e-5 voxels, over the gradient's length. Over noise central differences
/// all but cancel in a few pixels, whose normals turn by more than the others'.
void expect_shades(const Image& gpu, const Image& in_double) {
  EXPECT_LE(difference("surface", gpu, in_double).max, 2e-4);
  const auto [count, rms] = outliers(gpu, in_double, 3e-5);
  EXPECT_LE(rms, 1e-6);
  EXPECT_LE(count, 3);
}

/// Veils in front of an opaque surface and behind it, and a veil so dense that it is where half of
/// the light is left.
TEST_F(MarchModes, SeveralSurfacesAreTheReference) {
  for (const double last : {1.0, 0.4}) {
    View view = mode_view(perspective(), blobs(), Mode::isosurface);
    view.medium.surfaces = {{0.1, {1, 0.2, 0.1}, 0.2},
                            {0.25, {0.1, 1, 0.2}, 0.55},
                            {0.4, {0.2, 0.1, 1}, last},
                            {0.6, {1, 1, 1}, 1}};
    const Image reference = render_reference(view).image, image = deep_double(view);
    expect_content(reference);
    EXPECT_LE(difference("surfaces", image, reference).rms, 2e-6);  // as of one, up to six times
    expect_depth(view, image, reference);
    const Image gpu = deep_gpu(view);
    EXPECT_LE(difference("surfaces, gpu", gpu, image).rms, 2e-6);
    expect_depth(view, gpu, reference);
  }
}

TEST_F(MarchModes, SurfacesOnTheGpuAreTheMarchInDouble) {
  for (const bool second : {false, true}) {
    View view = either(second, mixed(), Mode::isosurface);
    const Image reference = render_reference(view).image, gpu = deep_gpu(view);
    expect_shades(gpu, double_picture(view));
    expect_depth(view, gpu, reference);
    view.scene.lights = {{{-1, -2, 0.5}, {1, 1, 1}}, {{1, 0.5, 0.2}, {0.1, 0.2, 0.3}}};
    const Image lit = double_picture(view);
    EXPECT_LE(difference("lit, double", lit, render_reference(view).image).rms, 1e-6);
    expect_shades(gl_picture(view), lit);
  }
}

TEST_F(MarchModes, SurfacesHaveTheColoursOfAGrid) {
  const auto wave = [](const glm::ivec3& v) {
    return 0.5f + 0.4f * std::sin(0.3f * float(v.x + 2 * v.y - v.z));
  };
  // on a lattice of its own, all around the density
  const glm::dmat4 tilted =
      glm::scale(glm::rotate(glm::dmat4(1), 0.5, glm::dvec3(1, 2, 3)), glm::dvec3(1.3, 1.1, 1.2));
  const Field scalar = make_field({{-40, -40, -40}, {60, 60, 60}}, wave, tilted);
  for (const bool vectors : {false, true}) {
    View view = mode_view(perspective(), mixed(), Mode::isosurface);
    const Image plain = double_picture(view);
    view.scene.lights = {{{-1, -2, 0.5}, {1, 1, 1}}};
    view.medium.source = vectors ? LuminanceSource::vector : LuminanceSource::scalar;
    view.medium.luminance = std::make_shared<const Field>(
        vectors
            ? map_field(scalar, 3, [](const glm::vec3& v) { return glm::vec3(v.x, 1 - v.x, 0.5f); })
            : scalar);
    const Image image = double_picture(view);
    // as accurate as the places of the surface: the grid's slope is below 1 over a voxel
    EXPECT_LE(difference("colours", image, render_reference(view).image).rms, 2e-6);
    EXPECT_GT(compare_images(image, plain).rms, 0.05);
    expect_shades(gl_picture(view), image);
  }
}

TEST_F(MarchModes, XrayIsTheReference) {
  for (const bool second : {false, true}) {
    View view = either(second, mixed(), Mode::xray);
    view.medium.extinction = 0.4;     // deeper than 1: a number, not an opacity
    view.scene.split_knots = second;  // pieces of cubics, which Simpson's rule integrates exactly
    const Image reference = render_reference(view).image, image = double_picture(view);
    expect_content(reference);
    // knots are bisected to 2^-20 of a cell
    EXPECT_LE(difference(what(Mode::xray, second), image, reference).rms, 2e-7);
    EXPECT_LE(difference(what(Mode::xray, second) + ", gpu", gl_picture(view), image).rms, 1e-6);
  }
}

/// The same sum from the other end.
TEST_F(MarchModes, BackToFrontIsAlpha) {
  struct Way {
    Integrator rule;
    bool uniform, function;
  };
  const Way ways[] = {{Integrator::psi_weighted, false, false},
                      {Integrator::psi_balanced, true, false},
                      {Integrator::midpoint, true, true},
                      {Integrator::preintegrated, false, true},
                      {Integrator::cell_exact, false, true}};
  for (const Way& way : ways) {
    View view = view_of(perspective(), mixed(), Glow::density);
    view.medium.extinction = 0.3;
    if (way.function) view = with_ramp(view);
    view.scene.integrator = way.rule;
    if (way.uniform) view.scene.sampling = Sampling::uniform;
    view.scene.step = 0.7;
    const Image front = double_picture(view);
    expect_content(front);
    view.scene.mode = Mode::back_to_front;
    const Image back = double_picture(view);
    const std::string name = info(way.rule).name;
    // cell-exact cuts rough pieces starting at the end it enters: two quadratures, each allowed
    // 1e-6
    EXPECT_LE(difference(name, back, front).rms, is_cell_rule(way.rule) ? 1e-6 : 1e-7);
    // one program per kind of rule, because building them takes most of this test's time
    if (way.rule == Integrator::midpoint || way.rule == Integrator::preintegrated) continue;
    EXPECT_LE(difference(name + ", gpu", gl_picture(view), back).rms, 1e-6);
  }
}

TEST(MarchModesDouble, UniformMaximaRiseToTheReference) {
  for (const Mode mode : {Mode::mip, Mode::lmip}) {
    Scene scene = perspective();
    double last = 1;
    for (const double step : {1.0, 0.25, 0.0625}) {
      scene.step = step;
      const View view = mode_view(scene, blobs(), mode);
      const Image image = double_picture(view), reference = render_reference(view).image;
      for (std::size_t i = 0; mode == Mode::mip && i < reference.rgba().size(); ++i)
        ASSERT_LE(image.rgba()[i], reference.rgba()[i] + 1e-7f);
      // Second order where a maximum is smooth, first order at a kink. Pixels whose ray grazes the
      // blobs, where the opacity jumps, are left out.
      const double rms = difference(std::string(mode_name(mode)) + " step " + std::to_string(step),
                                    image, reference)
                             .channel_rms[0];
      EXPECT_LE(rms, 0.25 * last);
      last = rms;
      // a maximum is of the steps' ends, whatever the rule reads of light
      View by_middles = view;
      by_middles.scene.integrator = Integrator::midpoint;
      EXPECT_EQ(difference("midpoint", double_picture(by_middles), image).max, 0);
    }
  }
}

TEST_F(MarchModes, UniformXrayAndMaximaOnTheGpuAreTheMarchInDouble) {
  double last = 1;
  Scene scene = perspective();
  for (const double step : {1.0, 0.25, 0.0625}) {
    scene.step = step;
    const View view = mode_view(scene, mixed(), Mode::xray);
    const Image image = double_picture(view);
    const Comparison c =
        difference("xray step " + std::to_string(step), image, render_reference(view).image);
    // second order on kinked data, a factor 16 each; half of it allows for the lattice's aliasing
    EXPECT_LE(c.rms, last / 8);
    last = c.rms;
    EXPECT_LE(difference("xray gpu", gl_picture(view), image).rms, 1e-6);
  }
  const View view = mode_view(scene, mixed(), Mode::mip);
  EXPECT_LE(difference("mip uniform gpu", gl_picture(view), double_picture(view)).rms, 1e-6);
}

}  // namespace
}  // namespace psivox
