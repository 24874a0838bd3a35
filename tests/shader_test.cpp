// PSIVOX_SHADER_DIR replaces the embedded shaders by another folder's; errors name the file and the
// line.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "blobs_scene.h"
#include "gl/shader_source.h"
#include "march_cases.h"
#include "psivox/draw.h"
#include "scratch.h"
#include "shader_copy.h"
#include "thrown.h"

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
    return error_of(ExitCode::graphics, [&] { picture(view); });
  }

  static View view(Glow glow = Glow::constant) { return view_of(oblique(16, 0.12), mixed(), glow); }
};

TEST_F(Shaders, TheFolderReplacesTheEmbeddedOnes) {
  const Image copied = picture(view());
  edit("march.frag", "out_picture = drawn(m, ray);", "out_picture = vec4(0.25, 0.5, 0.75, 1.0);");
  const Image edited = picture(view());
  EXPECT_EQ(pixel(edited, 3, 4, 0), 0.25f);
  EXPECT_EQ(pixel(edited, 3, 4, 2), 0.75f);
  unsetenv("PSIVOX_SHADER_DIR");
  EXPECT_EQ(difference("copied and embedded", copied, picture(view())).max, 0);
}

/// The rays of pixels left of `column` stay in their first brick.
void let_stand(const std::function<void(const std::string&, const std::string&)>& edit,
               const std::string& column) {
  edit("  Crossing far = leave(ray, s.run ? node.lo : m.cell, s.run ? node.side : 1);\n",
       "  Crossing far = leave(ray, s.run ? node.lo : m.cell, s.run ? node.side : 1);\n"
       "  if (drawn_at().x < " +
           column + " && node.kind == NODE_BRICK) far = Crossing(m.t, m.cell);\n");
}

TEST_F(Shaders, RaysThatStandStillEndAndAreCounted) {
  const Image whole = picture(view());
  let_stand([&](auto from, auto to) { edit("stretch.glsl", from, to); }, "8");
  for (const int turns : {0, 60}) {  // in one pass, and in several
    const Limited limited({.turns_per_pass = turns});
    GlRenderer gl({.debug = true});
    const Drawn drawn = Session(view()).draw(gl);
    EXPECT_GT(drawn.stats.stuck, 32u);
    EXPECT_LE(drawn.stats.stuck, 128u);
    EXPECT_EQ(drawn.stats.passes > 1, turns > 0);
    ASSERT_EQ(drawn.notices.size(), 1u);
    EXPECT_TRUE(has(drawn.notices[0], std::to_string(drawn.stats.stuck) + " rays stopped early"));
    std::uint64_t others = 0;
    for (int i = 3; i < 16 * 16 * 4; i += 4) {
      const float opacity = drawn.image.rgba()[std::size_t(i)];
      others += opacity != whole.rgba()[std::size_t(i)];
      EXPECT_LE(opacity, whole.rgba()[std::size_t(i)]);  // without the mark
    }
    EXPECT_GT(others, 32u);
    EXPECT_LE(others, drawn.stats.stuck);
  }
}

TEST_F(Shaders, ComputeShadersDrawWhatFragmentShadersDo) {
  Scene lit = blobs_scene();
  lit.resolution = {33, 18};
  lit.lights = {{glm::dvec3(0.3, -1, -0.5), glm::dvec3(1)}};
  lit.light_quality = LightQuality::exact;
  for (const int turns : {0, 12}) {  // in one pass, and in several
    Drawn drawn[2];
    for (const bool computes : {false, true}) {
      const Limited limited({.computes = computes, .turns_per_pass = turns});
      GlRenderer gl({.debug = true});
      drawn[computes] = Session(lit).draw(gl, {.layers = {.depth = true}, .count = true});
      EXPECT_EQ(drawn[computes].stats.passes > 1, turns > 0);
    }
    EXPECT_EQ(drawn[0].stats.samples, drawn[1].stats.samples);
    const Image &fragments = drawn[0].image, &computed = drawn[1].image;
    expect_content(fragments);
    // compilers may fuse other sums of the two: 16 roundings of 2^-24
    EXPECT_LE(difference("compute", fragments, computed).max, 16 * 0x1p-24);
    EXPECT_EQ(layer(fragments, "depth").values.size(), layer(computed, "depth").values.size());
    for (std::size_t i = 0; i < layer(computed, "depth").values.size(); ++i)
      EXPECT_FLOAT_EQ(layer(fragments, "depth").values[i], layer(computed, "depth").values[i]);
  }
}

TEST_F(Shaders, APassThatMovesNoRayIsAnError) {
  edit("passes.glsl", "  m.done = (d.z & 1) != 0;\n", "  m.done = false;\n  m.stuck = false;\n");
  edit("march.glsl", "      m.done = true;\n    }\n  }\n", "    }\n  }\n");
  let_stand([&](auto from, auto to) { edit("stretch.glsl", from, to); }, "16");
  const Limited limited({.turns_per_pass = 60});
  EXPECT_TRUE(has(graphics_error(view()), "a pass moved none of them"));
}

TEST_F(Shaders, EveryShaderIsEmbedded) {
  for (const auto& entry : fs::recursive_directory_iterator(PSIVOX_SHADERS)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = fs::relative(entry.path(), PSIVOX_SHADERS).string();
    const auto found = gl::embedded_shaders().find(name);
    ASSERT_NE(found, gl::embedded_shaders().end()) << name << " is not embedded";
    EXPECT_EQ(found->second, test::file_bytes(entry.path())) << name;
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
      {"march.frag", "void draw(ivec2 at) {"}};
  for (const auto& [name, text] : places)
    for (const std::string nonsense : {" nonsense here;", " undeclared = 1.0;"}) {
      const std::string where = std::string(text).substr(0, std::string(text).find('\n'));
      const int line = edit(name, text, where + nonsense + std::string(text).substr(where.size()));
      const std::string message = graphics_error(view(Glow::density));
      EXPECT_TRUE(has(message, std::string(name) + ":" + std::to_string(line) + ":"))
          << "; expected line " << line;
      edit(name, nonsense, "");
    }
  EXPECT_NO_THROW(picture(view()));
}

TEST_F(Shaders, MissingIncludesNameWhoWantsThem) {
  const int line = edit("medium.glsl", "#include \"ray.glsl\"", "#include \"rays.glsl\"");
  const std::string message = graphics_error(view());
  EXPECT_TRUE(has(message, "rays.glsl"));
  EXPECT_TRUE(has(message, "medium.glsl:" + std::to_string(line)));
}

TEST_F(Shaders, AFolderWithoutShadersIsSaidSo) {
  setenv("PSIVOX_SHADER_DIR", (folder_ / "nothing").c_str(), 1);
  const std::string message = graphics_error(view());
  EXPECT_TRUE(has(message, "PSIVOX_SHADER_DIR"));
}

TEST(ReducedSource, LeavesFaultsToTheDriversCompiler) {
  for (const char* faulty :
       {"void main() { if (true) {", "(", "{", "void main(", "a {", "const int", "f() {",
        "void main() { if (", "#endif", "x DERIVED(", "void main() { if (true) x"}) {
    gl::ShaderSource source;
    source.add_line(faulty, {"x", 1});
    EXPECT_NO_THROW(gl::reduced(source)) << faulty;
  }
}

}  // namespace
}  // namespace psivox
