#include "fetch_rate.h"

#include "gl/egl_context.h"
#include "gl/program.h"
#include "gl/tile_target.h"
#include "median.h"
#include "psivox/stopwatch.h"

namespace psivox::bench {
namespace {

constexpr int side = 512;
constexpr int lookups = 64;  ///< per pixel

constexpr const char* shader = R"glsl(
layout(location = 0) out vec4 out_picture;
layout(location = 1) out vec4 out_layers;
uniform samplerBuffer texels;
uniform int cells;  // of whole bricks of 9^3 texels

float fetch(int at) { return texelFetch(texels, at).x; }

void main() {
  int first = int(gl_FragCoord.x) + 512 * int(gl_FragCoord.y);
  vec4 sum = vec4(0.0);
  for (int i = 0; i < LOOKUPS; ++i) {
    int at = (first + 81 * i) % cells;  // a ray goes from slab to slab
    sum += vec4(fetch(at), fetch(at + 1), fetch(at + 9), fetch(at + 10));
    sum += vec4(fetch(at + 81), fetch(at + 82), fetch(at + 90), fetch(at + 91));
  }
  out_picture = sum;
  out_layers = vec4(0.0);
}
)glsl";

}  // namespace

bool is_software(const std::string& renderer) {
  return renderer.find("llvmpipe") != std::string::npos;
}

double fetch_rate(const BrickAtlas& atlas) {
  const gl::EglContext context({});
  const bool software = is_software(context.renderer());
  const gl::TileTarget target(side, false, false);
  const gl::Program program("fetch.frag", "#define LOOKUPS " + std::to_string(lookups) + "\n",
                            {{"fetch.frag", shader}});
  const std::size_t texels = atlas.bricks.size() * brick_texels;
  GLuint buffer = 0, texture = 0, vertex_array = 0;
  glCreateBuffers(1, &buffer);
  glNamedBufferStorage(buffer, GLsizeiptr(texels * sizeof(float)), atlas.texels32.get(), 0);
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &texture);
  glTextureBuffer(texture, GL_R32F, buffer);
  glCreateVertexArrays(1, &vertex_array);
  glBindVertexArray(vertex_array);
  program.set("texels", 0);
  program.set("cells", int(texels) - 91);
  glViewport(0, 0, side, side);

  std::vector<double> times;
  for (int i = 0; i < 8; ++i) {
    const Stopwatch watch;
    target.bind(0);
    glBindTextureUnit(0, texture);
    glUseProgram(program.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glFinish();
    if (i == 0) continue;  // the first draw compiles
    times.push_back(software ? watch.cpu_ms() : watch.ms());
  }
  context.check("fetching texels");
  glDeleteVertexArrays(1, &vertex_array);
  glDeleteTextures(1, &texture);
  glDeleteBuffers(1, &buffer);
  return 1e3 * lookups * double(side) * side / median(times);
}

}  // namespace psivox::bench
