#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "make_field.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "psivox/medium_atlas.h"
#include "psivox/reference.h"
#include "psivox/renderer.h"
#include "reference_cases.h"

// What the tests of the march share: one GL context a process, views of fields at hand, and
// differences of pictures.

namespace psivox {

/// The process's GL context. KHR_debug messages are errors.
class Gpu : public testing::Environment {
 public:
  /// Null on a machine without one; `problem` says why.
  static GlRenderer* renderer() {
    if (!self().renderer_ && self().problem_.empty()) {
      try {
        self().renderer_ = std::make_unique<GlRenderer>(ContextOptions{.debug = true});
      } catch (const Error& error) {
        if (error.code() != ExitCode::graphics) throw;
        self().problem_ = error.what();
      }
    }
    return self().renderer_.get();
  }
  static const std::string& problem() { return self().problem_; }
  void TearDown() override { renderer_.reset(); }

 private:
  static Gpu& self() {
    static Gpu* gpu = static_cast<Gpu*>(testing::AddGlobalTestEnvironment(new Gpu));
    return *gpu;
  }
  std::unique_ptr<GlRenderer> renderer_;
  std::string problem_;
};

/// A test with a GL context; skipped, and says so, where there is none.
class GpuTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!Gpu::renderer()) GTEST_SKIP() << "no GL device: " << Gpu::problem();
  }
};

// --- views ---------------------------------------------------------------------------------------

/// A square picture of a few pixels, never terminated early.
inline Scene small_scene(int side = 48) {
  Scene scene;
  scene.resolution = {side, side};
  scene.early_termination = 0;
  scene.extinction = 1;
  return scene;
}

inline std::shared_ptr<const Field> share(Field field) {
  return std::make_shared<const Field>(std::move(field));
}

enum class Glow { constant, density };

inline View view_of(const Scene& scene, std::shared_ptr<const Field> density,
                    Glow glow = Glow::constant) {
  return make_view(scene, density, glow == Glow::density ? density : nullptr);
}
inline View view_of(const Scene& scene, Field density, Glow glow = Glow::constant) {
  return view_of(scene, share(std::move(density)), glow);
}
inline View view_of(const Scene& scene, Field density, Field luminance) {
  return make_view(scene, share(std::move(density)), share(std::move(luminance)));
}

/// Looks at `target` from `position`, orthographic `width` world units wide if given.
inline Scene looking(Scene scene, const glm::dvec3& position, const glm::dvec3& target,
                     std::optional<double> width = {}) {
  scene.camera_position = position;
  scene.camera_target = target;
  if (width) {
    scene.projection = Projection::orthographic;
    scene.ortho_width = width;
  }
  return scene;
}

inline Scene with(Scene scene, Integrator rule, std::optional<double> step) {
  scene.integrator = rule;
  scene.step = step;
  return scene;
}

/// Ray of a pixel's centre.
inline WorldRay pixel_ray(const View& view, int x, int y) {
  return camera_ray(view.camera, view.scene.resolution, x + 0.5, y + 0.5);
}

// --- pictures ------------------------------------------------------------------------------------

struct GlOptions {
  RenderOptions render;
  int max_turns = 0;
  std::uint64_t max_buffer_texels = 0;
};

inline RenderResult render_gl(const View& view, const MediumAtlas& atlas,
                              const GlOptions& options = {}) {
  GlRenderer& gl = *Gpu::renderer();
  gl.upload(atlas, view.scene.filter, options.max_buffer_texels);
  return gl.render(view, options.render, options.max_turns);
}
inline Image gl_picture(const View& view) {
  return render_gl(view, build_medium_atlas(view)).image;
}

inline RenderResult render_double(const View& view, const MediumAtlas& atlas,
                                  const RenderOptions& options = {}) {
  return render_march_double(view, atlas, options);
}
inline Image double_picture(const View& view) {
  return render_double(view, build_medium_atlas(view)).image;
}

/// Difference of two pictures, printed and kept as the test's property.
inline Comparison difference(const std::string& what, const Image& a, const Image& b) {
  const Comparison c = compare_images(a, b);
  char text[96];
  std::snprintf(text, sizeof text, "rms %.2e max %.2e at %d,%d %s", c.rms, c.max, c.max_x, c.max_y,
                c.max_channel.c_str());
  std::printf("  %-44s %s\n", what.c_str(), text);
  testing::Test::RecordProperty(what, text);
  EXPECT_EQ(c.not_finite, 0u) << what;
  return c;
}

inline double mean_alpha(const Image& image) {
  double sum = 0;
  const auto rgba = image.rgba();
  for (std::size_t i = 3; i < rgba.size(); i += 4) sum += rgba[i];
  return sum / (double(image.width) * double(image.height));
}

/// Fails where a picture shows nothing, so that no comparison is of two blank ones.
inline void expect_content(const Image& image, double least = 0.02, double most = 0.999) {
  EXPECT_GE(mean_alpha(image), least);
  EXPECT_LE(mean_alpha(image), most);
}

inline float pixel(const Image& image, int x, int y, int channel) {
  return image.rgba()[std::size_t((y * image.width + x) * 4 + channel)];
}

inline const Layer& layer(const Image& image, const std::string& name) {
  for (const Layer& l : image.layers)
    if (l.name == name) return l;
  throw std::runtime_error("no layer " + name);
}

// --- fields --------------------------------------------------------------------------------------

/// Smooth blobs in a box of 40 x 36 x 32 voxels that starts at `at`, 0 around them.
inline float blobs_at(const glm::dvec3& p) {
  const auto blob = [&](const glm::dvec3& c, double r) {
    const glm::dvec3 d = (p - c) / r;
    return std::max(0.0, 1 - glm::dot(d, d));
  };
  return float(blob({12, 11, 12}, 9) + 0.7 * blob({26, 20, 18}, 10) + 2 * blob({20, 30, 8}, 4));
}
inline Field blobs(const glm::ivec3& at = {0, 0, 0}, const glm::dmat4& m = glm::dmat4(1)) {
  return make_field(
      {at, at + glm::ivec3(39, 35, 31)},
      [at](glm::ivec3 v) { return blobs_at(glm::dvec3(v - at)); }, m);
}

/// Blobs and rough noise in one, with constant bricks and empty ones.
inline Field mixed(const glm::dmat4& m = glm::dmat4(1)) {
  return make_field(
      {{-20, -12, -8}, {43, 35, 31}},
      [](glm::ivec3 v) {
        if (v.x < -2 && v.y >= 8) return 0.6f;
        if (v.x > 30) return v.y < 0 ? 0.0f : noise(v);
        return blobs_at(glm::dvec3(v));
      },
      m);
}

// --- files ---------------------------------------------------------------------------------------

inline std::filesystem::path shared_data() {
  const char* folder = std::getenv("PSIVOX_DATA");
  return folder ? folder : PSIVOX_SHARED_DATA;
}

}  // namespace psivox
