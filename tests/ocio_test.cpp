// Codes of 8 bits by a view of OpenColorIO must be those of `oiiotool --ociodisplay` on the EXR.

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "base/text.h"
#include "ocio_config.h"
#include "psivox/parameters.h"
#include "psivox/picture_file.h"
#include "scratch.h"
#include "thrown.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// The stored codes, alpha not multiplied.
std::vector<int> codes_of(const std::string& path) {
  OIIO::ImageSpec wish, spec;
  wish.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::create(path);
  if (!input || !input->open(path, spec, wish)) throw Error(ExitCode::input, path);
  std::vector<std::uint8_t> codes(spec.image_pixels() * std::size_t(spec.nchannels));
  EXPECT_TRUE(input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeUInt8, codes.data()));
  return {codes.begin(), codes.end()};
}

class OcioTest : public ::testing::Test {
 protected:
  OcioTest() {
    unsetenv("OCIO");
    write_ocio_config(config_);
  }
  ~OcioTest() override { unsetenv("OCIO"); }
  static std::string path(const std::string& name) { return (test::scratch_dir() / name).string(); }

  /// Light from 0 to 4 in all proportions of three colours; alpha grows along the rows.
  static Image picture(bool opaque) {
    constexpr int size = 32;
    Image image{size, size, {{"", {"R", "G", "B", "A"}, {}}}, {}};
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const float a = opaque ? 1 : float(x) / (size - 1);
        const float u = float(x) / (size - 1), v = float(y) / (size - 1);
        for (const float light : {4 * u * u, 2 * v * v, u * v})
          image.layers[0].values.push_back(a * light);
        image.layers[0].values.push_back(a);
      }
    return image;
  }
  Scene scene(const std::string& view) const {
    Scene result;
    result.ocio = config_;
    result.ocio_view = view;
    return result;
  }
  static void write(Image image, const Scene& scene, const std::string& path) {
    write_picture(image, scene, {}, "test", {path});
  }
  /// What oiiotool makes of the linear picture.
  std::vector<int> by_oiiotool(const Image& image, const std::string& how) const {
    write(image, {}, path("linear.exr"));
    const std::string line = "oiiotool --colorconfig " + shell_word(config_) + " " +
                             shell_word(path("linear.exr")) + " --ociodisplay:from=scene_linear" +
                             how + " -d uint8 -o " + shell_word(path("oiiotool.tif"));
    EXPECT_EQ(std::system(line.c_str()), 0) << line;
    return codes_of(path("oiiotool.tif"));
  }

  std::string config_ = path("config.ocio");
};

/// Both round the same floats to the nearest code; OpenImageIO may add a half before or after it
/// scales, so that a code is one beside the other where a float lies between two codes.
void expect_equal(const std::vector<int>& a, const std::vector<int>& b) {
  ASSERT_EQ(a.size(), b.size());
  int most = 0, differ = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    most = std::max(most, std::abs(a[i] - b[i]));
    differ += a[i] != b[i];
  }
  EXPECT_LE(most, 1);
  EXPECT_LE(differ, int(a.size() / 100));
}

TEST_F(OcioTest, EqualsOiiotool) {
  if (std::system("oiiotool --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no oiiotool";
  for (const std::string view : {"Plain", "Warm"}) {
    write(picture(true), scene(view), path("psivox.png"));
    expect_equal(codes_of(path("psivox.png")), by_oiiotool(picture(true), " Screen " + view));
    // a format without alpha stands over black
    write(picture(false), scene(view), path("psivox.webp"));
    std::vector<int> black = by_oiiotool(picture(false), ":unpremult=0 Screen " + view);
    std::vector<int> colours;
    for (std::size_t i = 0; i < black.size(); ++i)
      if (i % 4 != 3) colours.push_back(black[i]);
    const std::vector<int> own = codes_of(path("psivox.webp"));
    ASSERT_EQ(own.size(), colours.size());
    double sum = 0;  // lossy: quality 100 is 0.6 codes off
    for (std::size_t i = 0; i < own.size(); ++i) sum += std::abs(own[i] - colours[i]);
    EXPECT_LT(sum / double(own.size()), 1.5);
  }
}

TEST_F(OcioTest, ColourIsDividedByAlphaFirst) {
  write(picture(false), scene("Warm"), path("thin.png"));
  write(picture(true), scene("Warm"), path("opaque.png"));
  const std::vector<int> thin = codes_of(path("thin.png")), opaque = codes_of(path("opaque.png"));
  for (std::size_t i = 0; i < thin.size(); ++i)
    if (i % 4 != 3 && thin[i | 3] > 0) {
      EXPECT_NEAR(thin[i], opaque[i], 1);  // (a l) / a is rounded
    }
}

TEST_F(OcioTest, PlainViewIsThePictureWithoutOne) {
  write(picture(false), scene("Plain"), path("view.png"));
  write(picture(false), {}, path("none.png"));
  expect_equal(codes_of(path("view.png")), codes_of(path("none.png")));
}

TEST_F(OcioTest, TheEnvironmentAloneChangesNothing) {
  write(picture(false), {}, path("before.png"));
  setenv("OCIO", config_.c_str(), 1);
  write(picture(false), {}, path("after.png"));
  EXPECT_EQ(codes_of(path("before.png")), codes_of(path("after.png")));
  EXPECT_TRUE(read_scene_file(path("after.png")).scene.ocio.empty());
}

TEST_F(OcioTest, MetadataDrawTheSameAgain) {
  setenv("OCIO", config_.c_str(), 1);
  Scene asked;
  asked.ocio_view = "Warm";
  write(picture(true), asked, path("first.png"));
  unsetenv("OCIO");
  const Scene stored = read_scene_file(path("first.png")).scene;
  EXPECT_EQ(stored.ocio, config_);
  EXPECT_EQ(stored.ocio_display, "Screen");
  EXPECT_EQ(stored.ocio_space, "scene_linear");
  write(picture(true), stored, path("again.png"));
  EXPECT_EQ(codes_of(path("first.png")), codes_of(path("again.png")));
}

TEST_F(OcioTest, ExposureComesFirst) {
  Image brighter = picture(true);
  for (std::size_t i = 0; i < brighter.rgba().size(); ++i)
    if (i % 4 != 3) brighter.rgba()[i] *= 2;
  Scene exposed = scene("Warm");
  exposed.exposure = 1;
  write(picture(true), exposed, path("exposed.png"));
  write(brighter, scene("Warm"), path("brighter.png"));
  EXPECT_EQ(codes_of(path("exposed.png")), codes_of(path("brighter.png")));
}

TEST_F(OcioTest, RefusesInOneLine) {
  const auto message = [&](Scene scene, ExitCode code) {
    return error_of(code, [&] { resolve_ocio(scene); });
  };
  Scene none;
  none.ocio_view = "Warm";
  EXPECT_TRUE(has(message(none, ExitCode::usage), "--ocio FILE"));
  EXPECT_TRUE(has(message(scene("Cold"), ExitCode::input), "it has Plain, Warm"));
  Scene other = scene("Warm");
  other.ocio_display = "Wall";
  EXPECT_TRUE(has(message(other, ExitCode::input), "it has Screen"));
  other = scene("Warm");
  other.ocio_space = "moon";
  EXPECT_TRUE(has(message(other, ExitCode::input), "'moon'"));
  other.ocio = path("missing.ocio");
  EXPECT_TRUE(has(message(other, ExitCode::input), "missing.ocio"));
  other = scene("Warm");
  write_text(path("broken.ocio"), "displays: {");
  other.ocio = path("broken.ocio");
  EXPECT_TRUE(has(message(other, ExitCode::input), "broken.ocio"));
  Scene both = scene("Warm");
  both.tone_map = ToneMap::filmic;
  EXPECT_TRUE(has(usage_error([&] { validate(both); }), "--tone-map"));
}

TEST_F(OcioTest, TheLaterOfViewAndToneMapCounts) {
  Scene scene;
  scene.tone_map = ToneMap::filmic;  // as the look `fire` has stored it
  apply_over(scene, std::vector<Setting>{{"ocio", config_}});
  EXPECT_EQ(scene.tone_map, ToneMap::none);
  apply_over(scene, std::vector<Setting>{{"tone-map", "filmic"}});
  EXPECT_FALSE(scene.uses_ocio());
}

}  // namespace
}  // namespace psivox
