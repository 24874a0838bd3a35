// dense SCENE.json OUT.exr: draws a scene by a dense-texture ray marcher, the baseline that psivox
// is measured against: dense.frag over one dense 3D texture of the domain in float32, drawn as one
// tile with the scene's step and filter. Luminance is constant or the density grid.
// compare_peers.py runs it; it prints {"march_ms": .., "march_cpu_ms": ..} of the second picture.
#include <cstdio>

#include "base/stopwatch.h"
#include "base/text_file.h"
#include "gl/egl_context.h"
#include "gl/march_program.h"
#include "gl/program.h"
#include "gl/tiles.h"
#include "march/medium_atlas.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/field.h"
#include "psivox/parameters.h"

namespace {

using namespace psivox;

/// The texture of a field's domain, z fastest.
GLuint dense_texture(const Field& field) {
  const Box domain = field.domain();
  const glm::ivec3 size = domain.max - domain.min + 1;
  std::vector<float> values(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z));
  write_dense(field, domain, values.data());
  GLuint texture = 0;
  glCreateTextures(GL_TEXTURE_3D, 1, &texture);
  glTextureStorage3D(texture, 1, GL_R32F, size.z, size.y, size.x);
  glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureSubImage3D(texture, 0, 0, 0, 0, size.z, size.y, size.x, GL_RED, GL_FLOAT, values.data());
  return texture;
}

std::string prelude_of(MarchSetup setup, const Medium& medium) {
  return gl::program_key(setup, {}).prelude() + gl::common_prelude(gl::program_form()) +
         "#define LUMINANCE_DENSITY " + std::to_string(medium.source == LuminanceSource::density) +
         "\n";
}

void draw(const View& view, const std::string& output) {
  const gl::EglContext context({});
  const glm::ivec2 size = view.scene.resolution;
  const gl::TileTarget target(std::max(size.x, size.y), false, false);
  const gl::EachPixel pixels;
  const MediumAtlas atlas = build_medium_atlas(view);
  const MarchSetup setup = make_march_setup(view, atlas);
  const gl::Program program("dense.frag",
                            gl::load_shader("dense.frag", prelude_of(setup, view.medium),
                                            {{"dense.frag", read_text(DENSE_SHADER, "shader")}}),
                            gl::program_form().computes);
  gl::set_parameters(program, setup.parameters);
  program.set("tile_origin", glm::ivec2(0));
  program.set("volume", 0);
  const GLuint texture = dense_texture(*view.medium.density);
  Image image = rgba_image(size.x, size.y);
  for (const bool timed : {false, true}) {
    const Stopwatch watch;
    target.bind(0);
    glBindTextureUnit(0, texture);
    pixels.run(program, size.x, size.y);
    target.read_picture(size.x, size.y, reinterpret_cast<glm::vec4*>(image.layers[0].values.data()),
                        size.x);
    if (timed)
      std::printf("{\"march_ms\": %.3f, \"march_cpu_ms\": %.3f}\n", watch.ms(), watch.cpu_ms());
  }
  context.check("drawing the dense volume");
  glDeleteTextures(1, &texture);
  write_image(image, output);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) throw Error(ExitCode::usage, "dense SCENE.json OUT.exr");
  const Scene scene = scene_from_json(read_text(argv[1], "scene"));
  draw(make_view(scene, VdbFile(scene.input)), argv[2]);
  return 0;
} catch (const Error& error) {
  std::fprintf(stderr, "dense: %s\n", error.what());
  return int(error.code());
}
