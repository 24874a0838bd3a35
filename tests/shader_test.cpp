// PSIVOX_SHADER_DIR replaces the embedded shaders by another folder's; errors name the file and the
// line.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>

#include "blobs_scene.h"
#include "gl/shader_source.h"
#include "gl/webgl_march.h"
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
    EXPECT_TRUE(has(drawn.notices[0], std::to_string(drawn.stats.stuck) + " rays stood still"));
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

TEST(ShaderSource, LogsOfBothKindsOfDriverAreMapped) {
  gl::ShaderSource source;
  for (int i = 1; i <= 3; ++i) source.add_line("", {"march.frag", i});
  for (int i = 1; i <= 9; ++i) source.add_line("", {"ray.glsl", i});
  EXPECT_EQ(source.map_log("0:10(5): error: x"), "ray.glsl:7: error: x");
  EXPECT_EQ(source.map_log("0(10) : error C1: x"), "ray.glsl:7: error C1: x");
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
  EXPECT_FALSE(has(source.text, "#include"));
}

TEST(Macros, AreReplacedAsByAPreprocessor) {
  gl::Macros macros;
  EXPECT_EQ(macros.expanded("#define real float\n"
                            "#define PAIR(type, name) type name##_a, \\\n"
                            "  name ## _b;\n"
                            "#define own(x) own(x + 1e-3)\n"
                            "PAIR(real, u)\n"
                            "own(max(real, 2.0)); own; surreal real3\n"
                            "#undef real\n"
                            "real\n"),
            "float u_a,    u_b;\n"
            "own(max(float, 2.0) + 1e-3); own; surreal real3\n"
            "real\n");
}

TEST(WebGlText, SetsGlobalsInMainAndRoundsWhatIsPrecise) {
  gl::ShaderSource source;
  for (const char* line :
       {"#version 450 core", "uniform samplerBuffer tables;", "uniform usamplerBuffer codes[1];",
        "uniform float given;", "const float two = 2.0;", "float step = two * given;",
        "float unread = given;", "void main() {", "  precise float t = step * two;",
        "  gl_FragDepth = t + texelFetch(tables, int(texelFetch(codes[0], 7).x)).x;", "}"})
    source.add_line(line, {});
  const std::string text = gl::webgl_text(source, {"tables"});
  EXPECT_TRUE(text.starts_with("#version 300 es\n"));
  std::string own = text.substr(text.find("uniform sampler2D tables"));
  std::erase(own, ' ');
  EXPECT_EQ(own,
            "uniformsampler2Dtables;\n\nuniformfloatgiven;\nconstfloattwo=2.0;\n"
            "floatlattice_step;\n\nvoidmain(){\nlattice_step=two*given;\n\n"
            "floatt=exactly(lattice_step*two);\n"
            "gl_FragDepth=t+entry_of(tables,int(uvec4(0u).x)).x;\n}\n");
  EXPECT_EQ(gl::webgl_name("given.step"), "given.lattice_step");
}

/// The text of `reduced`, line by line with single spaces, and the lines' numbers.
std::string reduced_text(const std::string& text) {
  gl::ShaderSource source;
  std::istringstream lines(text);
  std::string line, result;
  for (int i = 1; std::getline(lines, line); ++i) source.add_line(line, {"x", i});
  const gl::ShaderSource reduced = gl::reduced(source);
  std::istringstream left(reduced.text);
  for (std::size_t i = 0; std::getline(left, line); ++i) {
    result += std::to_string(reduced.places.at(i).line) + ":";
    std::istringstream words(line);
    for (std::string word; words >> word;) result += " " + word;
    result += "\n";
  }
  return result;
}

TEST(ReducedSource, DropsBranchesOnConstantsAndWhatIsNotReached) {
  EXPECT_EQ(reduced_text("const bool on = true;\n"
                         "const int two = 2;\n"
                         "DERIVED(bool, off, !on || two == 3)\n"
                         "float unused(float x) { return x; }\n"
                         "float only_if_off(float x) { return unused(x); }\n"
                         "float wanted(float x) { return x; }\n"
                         "void main() {\n"
                         "  float x = 1.0;  // said\n"
                         "  if (off && x > 0.0) x = only_if_off(x);\n"
                         "  else x = wanted(x);\n"
                         "  for (int i = 0; i < 2; ++i) if (off) x = unused(x);\n"
                         "  if (x > 0.0 && on) x = 2.0;\n"
                         "  if (on) { x = 3.0; return; }\n"
                         "  x = unused(x);\n"
                         "}\n"),
            "1: const bool on = true;\n"
            "2: const int two = 2;\n"
            "3: DERIVED(bool, off, !on || two == 3)\n"
            "6: float wanted(float x) { return x; }\n"
            "7: void main() {\n"
            "8: float x = 1.0;\n"
            "10: x = wanted(x);\n"
            "11: for (int i = 0; i < 2; ++i) ;\n"
            "12: if (x > 0.0 && on) x = 2.0;\n"
            "13: { x = 3.0; return; }\n"
            "15: }\n");
}

TEST(ReducedSource, DecidesConditionalPartsAndKeepsWhatMacrosUse) {
  EXPECT_EQ(reduced_text("#define BITS 32\n"
                         "const bool on = false;\n"
                         "float by_macro() { return 1.0; }\n"
                         "#define CALL(x) x * by_macro()\n"
                         "#if BITS == 64\n"
                         "float narrow() { return 2.0; }\n"
                         "#else\n"
                         "float narrow(bool on) { if (on) return 3.0; return 4.0; }\n"
                         "#endif\n"
                         "void main() { CALL(narrow(on)); }\n"),
            "1: #define BITS 32\n"
            "2: const bool on = false;\n"
            "3: float by_macro() { return 1.0; }\n"
            "4: #define CALL(x) x * by_macro()\n"
            "8: float narrow(bool on) { if (on) return 3.0; return 4.0; }\n"
            "10: void main() { CALL(narrow(on)); }\n");
}

TEST(ReducedSource, LeavesWhatItDoesNotRead) {
  const std::string condition = "#ifdef GL_ES\nfloat f() { return 1.0; }\n#endif\n";
  EXPECT_EQ(reduced_text(condition), "1: #ifdef GL_ES\n2: float f() { return 1.0; }\n3: #endif\n");
  // the driver's compiler finds the faults
  for (const char* faulty :
       {"#version 450\nvoid main() { if (true) {\n", "(", "{", "void main(", "a {", "const int",
        "f() {", "void main() { if (", "#endif\n", "x DERIVED(", "void main() { if (true) x"})
    EXPECT_NO_THROW(reduced_text(faulty)) << faulty;
}

}  // namespace
}  // namespace psivox
