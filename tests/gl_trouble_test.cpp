// Functions of OpenGL are replaced by those of this file: devices that fail, and draws that count.

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/text_file.h"
#include "blobs_scene.h"
#include "gl/march_program.h"
#include "march/marcher.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "psivox/study.h"
#include "study/results.h"
#include "thrown.h"

namespace psivox {
namespace {

constexpr std::int64_t plenty = std::int64_t(1) << 40;  // [bytes]

/// A device with little memory for buffers, which may also lose its context. It counts bytes.
struct Device {
  std::int64_t capacity = plenty;
  std::int64_t held = 0;
  std::int64_t most_held = 0;
  std::map<GLuint, std::int64_t> buffers;
  GLenum error = GL_NO_ERROR;
  GLenum reset = GL_NO_ERROR;
  decltype(epoxy_glNamedBufferStorage) storage = epoxy_glNamedBufferStorage;
  decltype(epoxy_glDeleteBuffers) remove = epoxy_glDeleteBuffers;
  decltype(epoxy_glGetError) get_error = epoxy_glGetError;
  decltype(epoxy_glGetGraphicsResetStatus) reset_status = epoxy_glGetGraphicsResetStatus;
};

Device* device = nullptr;

void store(GLuint buffer, GLsizeiptr size, const void* data, GLbitfield flags) {
  if (device->held + size > device->capacity) {
    device->error = GL_OUT_OF_MEMORY;
    return;
  }
  device->held += size;
  device->most_held = std::max(device->most_held, device->held);
  device->buffers[buffer] = size;
  device->storage(buffer, size, data, flags);
}

void remove_buffers(GLsizei count, const GLuint* buffers) {
  for (GLsizei i = 0; i < count; ++i) {
    device->held -= device->buffers[buffers[i]];
    device->buffers.erase(buffers[i]);
  }
  device->remove(count, buffers);
}

GLenum get_error() {
  const GLenum found = std::exchange(device->error, GL_NO_ERROR);
  return found != GL_NO_ERROR ? found : device->get_error();
}

GLenum reset_status() { return device->reset; }

class GlTrouble : public testing::Test {
 protected:
  void SetUp() override {
    gl::test_limits = {.copies_texels = true};  // into buffers, which are counted
    marcher_ = open_gpu();
    for (int n = 0; n < 2; ++n)
      Session(blobs_scene())
          .draw(*marcher_);  // libepoxy finds each function when it is first called
    device_ = Device();
    device = &device_;
    epoxy_glNamedBufferStorage = store;
    epoxy_glDeleteBuffers = remove_buffers;
    epoxy_glGetError = get_error;
    epoxy_glGetGraphicsResetStatus = reset_status;
  }

  void TearDown() override {
    marcher_.reset();
    epoxy_glNamedBufferStorage = device_.storage;
    epoxy_glDeleteBuffers = device_.remove;
    epoxy_glGetError = device_.get_error;
    epoxy_glGetGraphicsResetStatus = device_.reset_status;
    gl::test_limits = {};
  }

  Device device_;
  std::shared_ptr<Marcher> marcher_;
};

TEST_F(GlTrouble, AFullDeviceDrawsInParts) {
  for (const bool lit : {false, true}) {
    Scene scene = blobs_scene();
    if (lit) {
      scene.lights = {{glm::dvec3(0.3, -1, -0.5), glm::dvec3(1)}};
      scene.light_quality = LightQuality::exact;
    }
    const Image whole = Session(scene).draw(*marcher_).image;
    const std::int64_t needed = std::exchange(device_.most_held, 0);
    device_.capacity = needed * 3 / 4;
    Session session(scene);
    const Drawn drawn = session.draw(*marcher_);
    ASSERT_FALSE(drawn.notices.empty());
    EXPECT_TRUE(has(drawn.notices.back(), "parts"));
    EXPECT_LE(device_.most_held, device_.capacity);
    // Parts find the same cells, and read the same texels. Light's depths are sums over parts.
    // Rays are placed by quotients, of which GLSL allows five times IEEE's error (4.50, 4.7.1).
    const double rounding = is_software(marcher_->description()) ? 4e-7 : 5 * 4e-7;
    EXPECT_LE(compare_images(whole, drawn.image).max, rounding);
    Scene exact = scene;
    exact.renderer = RendererKind::march_double;
    const Image truth = Session(exact).draw(*open_marcher(exact)).image;
    EXPECT_LE(compare_images(whole, truth).max, rounding);
    EXPECT_LE(compare_images(drawn.image, truth).max, rounding);
    // the next picture goes into parts at once
    device_.error = GL_NO_ERROR;
    EXPECT_EQ(compare_images(drawn.image, session.draw(*marcher_).image).max, 0);
    device_.capacity = plenty;
    device_.most_held = 0;
  }
}

TEST_F(GlTrouble, ADeviceThatHoldsNothingSaysSo) {
  device_.capacity = 1000;
  const auto full = [&](const Scene& scene) {
    return error_of(ExitCode::memory, [&] { Session(scene).draw(*marcher_); });
  };
  for (const char* part : {"memory is full", "--lod 1"})
    EXPECT_TRUE(has(full(blobs_scene()), part));
  // what cannot be drawn in parts says the same
  Scene uniform = blobs_scene();
  uniform.sampling = Sampling::uniform;
  EXPECT_NE(full(uniform), "no error");
  // and the marcher draws again when there is memory
  device_.capacity = plenty;
  EXPECT_NO_THROW(Session(blobs_scene()).draw(*marcher_));
}

TEST_F(GlTrouble, ALostContextSaysSo) {
  Session session(blobs_scene());
  session.draw(*marcher_);
  const auto expect_lost = [&] {
    const std::string message = error_of(ExitCode::graphics, [&] { session.draw(*marcher_); });
    EXPECT_TRUE(has(message, "reset"));
  };
  device_.reset = GL_INNOCENT_CONTEXT_RESET;
  expect_lost();
  device_.reset = GL_NO_ERROR;
  device_.error = GL_CONTEXT_LOST;
  expect_lost();
}

/// Programs that draws were made with. A driver compiles a program at its first draw.
struct Draws {
  GLuint program = 0;
  std::set<GLuint> programs{};
  decltype(epoxy_glUseProgram) use = epoxy_glUseProgram;
  decltype(epoxy_glDrawArrays) draw = epoxy_glDrawArrays;
  decltype(epoxy_glDispatchCompute) dispatch = epoxy_glDispatchCompute;
};

Draws* draws = nullptr;

void use_program(GLuint program) {
  draws->program = program;
  draws->use(program);
}

void dispatch(GLuint x, GLuint y, GLuint z) {
  draws->programs.insert(draws->program);
  draws->dispatch(x, y, z);
}

void draw_arrays(GLenum kind, GLint first, GLsizei count) {
  draws->programs.insert(draws->program);
  draws->draw(kind, first, count);
}

/// A picture that a GPU draws by compute shaders is one dispatch, and the pilot's rays are another:
/// between tiles the GPU would wait for the longest rays of each.
TEST_F(GlTrouble, AGpuDrawsAPictureAtOnce) {
  Scene scene = blobs_scene();
  scene.resolution = {640, 360};
  scene.integrator.reset();
  scene.sampling.reset();
  scene.tolerance = 1e-3;
  gl::test_limits.computes = false;
  const Image tiles = Session(scene).draw(*open_gpu()).image;
  gl::test_limits.computes = true;
  const auto gpu = open_gpu();
  Session(scene).draw(*gpu);  // libepoxy finds the function
  static std::string calls;   // d: a dispatch, r: a read, which waits
  static decltype(epoxy_glDispatchCompute) dispatches;
  static decltype(epoxy_glReadPixels) reads;
  calls.clear();
  dispatches = std::exchange(epoxy_glDispatchCompute, [](GLuint x, GLuint y, GLuint z) {
    calls += 'd';
    dispatches(x, y, z);
  });
  reads = std::exchange(epoxy_glReadPixels, [](GLint x, GLint y, GLsizei width, GLsizei height,
                                               GLenum format, GLenum type, void* pixels) {
    calls += 'r';
    reads(x, y, width, height, format, type, pixels);
  });
  const Image at_once = Session(scene).draw(*gpu).image;
  epoxy_glDispatchCompute = dispatches;
  epoxy_glReadPixels = reads;
  // pilot and picture; a driver on the CPU compiles by two more
  EXPECT_EQ(calls, is_software(marcher_->description()) ? "ddddrr" : "ddrr");
  EXPECT_LE(compare_images(tiles, at_once).max, 16 * 0x1p-24);  // as in shader_test
}

TEST_F(GlTrouble, WhatAStudyTimesHasDrawnBefore) {
  Draws counted;
  draws = &counted;
  epoxy_glUseProgram = use_program;
  epoxy_glDrawArrays = draw_arrays;
  epoxy_glDispatchCompute = dispatch;
  StudyOptions options;
  options.folder = std::filesystem::path(testing::TempDir()) / "study_of_one_round";
  std::filesystem::remove_all(options.folder);
  options.repeats = 1;
  options.split = false;
  set_sweep(options.sweep, "integrators", "porter-duff,midpoint,psi-weighted");
  set_sweep(options.sweep, "segments", "1");
  set_sweep(options.sweep, "steps", "1");
  const std::string file = (options.folder / "results.json").string();
  std::vector<std::size_t> before, timed;  // programs, when nothing was timed and since then
  options.progress = [&](double) {
    if (!std::filesystem::exists(file)) return;
    const StudyResults results = results_from_json(read_text(file, "study"), file);
    const bool any = std::ranges::any_of(
        results.points, [](const StudyPoint& point) { return !point.times.empty(); });
    (any ? timed : before).push_back(counted.programs.size());
  };
  Scene scene = blobs_scene();
  scene.luminance_grid = "density";
  run_study(Session(scene).view(), options);
  epoxy_glUseProgram = counted.use;
  epoxy_glDrawArrays = counted.draw;
  epoxy_glDispatchCompute = counted.dispatch;
  ASSERT_FALSE(before.empty());
  const std::size_t times = 6;  // three rules in two samplings
  ASSERT_GE(timed.size(), times);
  EXPECT_GE(before.back(), 6u);
  // behind the times comes the page that turns, whose picture may have a program of its own
  EXPECT_EQ(timed[times - 1], before.back()) << "a program was built in one rule's time";
}

}  // namespace
}  // namespace psivox
