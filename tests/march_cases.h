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

#include "gl/gl_renderer.h"
#include "gl/march_program.h"
#include "made_fields.h"
#include "march/march_double.h"
#include "march/medium_atlas.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "reference/reference.h"
#include "reference_cases.h"
#include "scene/environment.h"

// Shared by the tests of the march: one GL context per process, and differences of pictures. Their
// fields and views are verify's.

namespace psivox {

/// The process's GL context. KHR_debug messages are errors.
class Gpu : public testing::Environment {
 public:
  /// Null on a machine without one; `problem` gives the reason.
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

/// A test with a GL context. It is skipped, with a message, if there is none.
class GpuTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!Gpu::renderer()) GTEST_SKIP() << "no GL device: " << Gpu::problem();
  }
};

/// How far off a driver's quotients may be, by which rays are placed, over IEEE's half ulp. Those
/// that run on the CPU divide as IEEE says; GLSL allows 2.5 ulp (4.50, section 4.7.1).
inline double quotient_errors() { return is_software(Gpu::renderer()->description()) ? 1 : 5; }

// --- pictures ------------------------------------------------------------------------------------

inline const RenderOptions all_layers{
    .count = true, .depth = true, .transmittance = true, .progress = {}};

struct GlOptions {
  RenderOptions render;
  gl::TestLimits limits{};
};

/// Lowers the renderers' limits for its life.
struct Limited {
  explicit Limited(const gl::TestLimits& limits) { gl::test_limits = limits; }
  ~Limited() { gl::test_limits = {}; }
};

inline RenderResult render_gl(const View& view, const MediumAtlas& atlas,
                              const GlOptions& options = {}) {
  GlRenderer& gl = *Gpu::renderer();
  const Limited limited(options.limits);
  gl.upload(atlas, view.scene.filter);
  return gl.render(view, options.render);
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

/// Difference of two pictures, printed and recorded as the test's property.
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

inline const char* name_of(LuminanceSource source) {
  return source == LuminanceSource::constant  ? ", constant L"
         : source == LuminanceSource::density ? ", L = value"
         : source == LuminanceSource::scalar  ? ", L from a grid"
                                              : ", own colours";
}

/// Fails if a picture is blank, so that a comparison never accepts two blank pictures.
inline void expect_content(const Image& image, double least = 0.02, double most = 0.999) {
  EXPECT_GE(mean_alpha(image), least);
  EXPECT_LE(mean_alpha(image), most);
}

/// Radiance is that of two pictures together.
inline void expect_sum(const Image& both, const Image& a, const Image& b, double tolerance) {
  for (std::size_t i = 0; i < both.rgba().size(); ++i)
    if (i % 4 != 3) {
      ASSERT_NEAR(both.rgba()[i], a.rgba()[i] + b.rgba()[i], tolerance) << i;
    }
}

/// The bounds of float32's arithmetic: RMS 1e-6, and max 2e-5 where a ray along a face enters the
/// other cell.
inline void expect_arithmetic(const std::string& what, const Image& gpu, const Image& wide) {
  const Comparison c = difference(what, gpu, wide);
  EXPECT_LE(c.rms, 1e-6) << what;
  EXPECT_LE(c.max, 2e-5) << what;
}

/// The GPU draws a view as the march in double does, and something.
inline void expect_arithmetic(const std::string& what, const View& view, const MediumAtlas& atlas,
                              double least_content = 0.02) {
  const Image gpu = render_gl(view, atlas).image;
  expect_content(gpu, least_content);
  expect_arithmetic(what, gpu, render_double(view, atlas).image);
}

inline const Layer& layer(const Image& image, const std::string& name) {
  for (const Layer& l : image.layers)
    if (l.name == name) return l;
  throw std::runtime_error("no layer " + name);
}

/// Errors with 1, 2 and 4 segments per cell, or steps of 1, 1/2 and 1/4 voxel: they fall, and
/// overall by `order`.
inline void expect_convergence(const std::string& what, View view, const Image& reference,
                               double order) {
  const bool uniform = view.scene.sampling == Sampling::uniform;
  double first = 0, last = HUGE_VAL;
  for (const int n : {1, 2, 4}) {
    if (uniform) {
      view.scene.step = 1.0 / n;
    } else {
      view.scene.segments = n;
    }
    const double rms = difference(what + (uniform ? " 1/step " : " segments ") + std::to_string(n),
                                  double_picture(view), reference)
                           .rms;
    EXPECT_LT(rms, last) << what << ' ' << n;
    last = rms;
    if (n == 1) first = rms;
  }
  EXPECT_LE(last, first * std::pow(4, -order)) << what;
}

/// A square picture of `mixed` from outside.
inline Scene oblique(int side, double extinction) {
  return looking(small_scene(side, extinction), {95, 60, 70}, {11, 12, 11});
}

// --- files ---------------------------------------------------------------------------------------

inline std::filesystem::path shared_data() {
  const char* folder = std::getenv("PSIVOX_DATA");
  return folder ? folder : PSIVOX_SHARED_DATA;
}

}  // namespace psivox
