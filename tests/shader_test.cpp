// PSIVOX_SHADER_DIR replaces the embedded shaders by another folder's; errors name the file and the
// line.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "gl/embedded_shaders.h"
#include "gl/shader_source.h"
#include "march_cases.h"
#include "shader_copy.h"

namespace psivox {
namespace {

/// Pictures drawn with the shaders of a folder.
class Shaders : public ShaderTest {
 protected:
  /// Uses its own renderer, so that no program is cached.
  static Image picture(const View& view) {
    const MediumAtlas atlases = build_medium_atlas(view);
    GlRenderer gl({.debug = true});
    gl.upload(atlases);
    return gl.render(view).image;
  }

  static std::string graphics_error(const View& view) {
    try {
      picture(view);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::graphics);
      const std::string message = error.what();
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      return message;
    }
    return "no error";
  }

  static View view(Glow glow = Glow::constant) {
    Scene scene = looking(small_scene(16), {95, 60, 70}, {11, 12, 11});
    scene.extinction = 0.12;
    return view_of(scene, mixed(), glow);
  }
};

TEST_F(Shaders, TheFolderReplacesTheEmbeddedOnes) {
  const Image copied = picture(view());
  edit("march.frag", "out_picture = picture(m, p);", "out_picture = vec4(0.25, 0.5, 0.75, 1.0);");
  const Image edited = picture(view());
  EXPECT_EQ(pixel(edited, 3, 4, 0), 0.25f);
  EXPECT_EQ(pixel(edited, 3, 4, 2), 0.75f);
  unsetenv("PSIVOX_SHADER_DIR");
  EXPECT_EQ(difference("copied and embedded", copied, picture(view())).max, 0);
}

TEST_F(Shaders, EveryShaderIsEmbedded) {
  for (const auto& entry : fs::recursive_directory_iterator(PSIVOX_SHADERS)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = fs::relative(entry.path(), PSIVOX_SHADERS).string();
    const auto found = gl::embedded_shaders().find(name);
    ASSERT_NE(found, gl::embedded_shaders().end()) << name << " is not embedded";
    EXPECT_EQ(found->second, contents(entry.path())) << name;
  }
}

TEST_F(Shaders, ErrorsNameFileAndLine) {
  // Errors in files included at the beginning, the middle and the end, two folders deep, and in a
  // file generated for the program: syntax, and an undeclared name.
  const std::pair<const char*, const char*> places[] = {
      {"binding.glsl", "uint fetch_page(int grid, int i) {"},
      {"ray.glsl", "real3 position(Ray ray, real t) {"},
      {"ray_state.glsl", "March begin_march(Ray ray) {"},
      {"pixel.glsl", "Pixel make_pixel(real2 pixel) {"},
      {"math/decay.glsl", "Decay decay(real x) {\n  real y"},
      {"integrators/psi_weighted.glsl", "Weights psi_weighted(Segment s) {"},
      {"march.frag", "void main() {"}};
  for (const auto& [name, text] : places)
    for (const std::string nonsense : {" nonsense here;", " undeclared = 1.0;"}) {
      const std::string where = std::string(text).substr(0, std::string(text).find('\n'));
      const int line = edit(name, text, where + nonsense + std::string(text).substr(where.size()));
      const std::string message = graphics_error(view(Glow::density));
      EXPECT_NE(message.find(std::string(name) + ":" + std::to_string(line) + ":"),
                std::string::npos)
          << message << "; expected line " << line;
      edit(name, nonsense, "");
    }
  EXPECT_NO_THROW(picture(view()));
}

TEST_F(Shaders, MissingIncludesNameWhoWantsThem) {
  const int line = edit("medium.glsl", "#include \"ray.glsl\"", "#include \"rays.glsl\"");
  const std::string message = graphics_error(view());
  EXPECT_NE(message.find("rays.glsl"), std::string::npos) << message;
  EXPECT_NE(message.find("medium.glsl:" + std::to_string(line)), std::string::npos) << message;
}

TEST_F(Shaders, AFolderWithoutShadersIsSaidSo) {
  setenv("PSIVOX_SHADER_DIR", (folder_ / "nothing").c_str(), 1);
  const std::string message = graphics_error(view());
  EXPECT_NE(message.find("PSIVOX_SHADER_DIR"), std::string::npos) << message;
}

TEST(ShaderSource, LogsOfBothKindsOfDriverAreMapped) {
  gl::ShaderSource source;
  for (int i = 1; i <= 3; ++i) source.add_line("", {"march.frag", i});
  for (int i = 1; i <= 9; ++i) source.add_line("", {"ray.glsl", i});
  EXPECT_EQ(source.map_log("0:10(5): error: x"), "ray.glsl:7: error: x");
  EXPECT_EQ(source.map_log("0(10) : error C1: x"), "ray.glsl:7 : error C1: x");
  EXPECT_EQ(source.map_log("0:3(1): a\n0:4(2): b"), "march.frag:3: a\nray.glsl:1: b");
  EXPECT_EQ(source.map_log("0:17(5): error"), "0:17(5): error");
  EXPECT_EQ(source.map_log("no place"), "no place");
}

TEST(ShaderSource, EveryLineKnowsItsPlace) {
  const gl::ShaderSource source =
      gl::load_shader("march.frag", "a\nb\n",
                      {{"integrator.glsl", "#include \"integrators/midpoint.glsl\"\nlast\n"}});
  EXPECT_EQ(std::size_t(std::count(source.text.begin(), source.text.end(), '\n')),
            source.places.size());
  EXPECT_EQ(source.places[0].file, "version");
  EXPECT_EQ(source.places[2].file, "prelude");
  EXPECT_EQ(source.places[2].line, 2);
  EXPECT_EQ(source.text.find("#include"), std::string::npos);
}

}  // namespace
}  // namespace psivox
