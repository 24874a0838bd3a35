#include "dense_renderer.h"

#include <glm/common.hpp>

#include "dense_shader.h"
#include "gl/march_program.h"
#include "psivox/error.h"
#include "psivox/stopwatch.h"

namespace psivox::bench {

DenseRenderer::DenseRenderer(const Field& field, int side)
    : context_({}), target_(side, false, false) {
  const Box domain = field.domain();
  const glm::ivec3 size = domain.max - domain.min + 1;
  const auto index = [&](const glm::ivec3& at) {
    return (std::size_t(at.x) * std::size_t(size.y) + std::size_t(at.y)) * std::size_t(size.z) +
           std::size_t(at.z);
  };
  std::vector<float> values(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z));
  const auto fill = [&](const glm::ivec3& origin, int width, auto value) {
    const glm::ivec3 lo = glm::max(origin, domain.min);
    const glm::ivec3 hi = glm::min(origin + width - 1, domain.max);
    for (int x = lo.x; x <= hi.x; ++x)
      for (int y = lo.y; y <= hi.y; ++y)
        for (int z = lo.z; z <= hi.z; ++z)
          values[index(glm::ivec3(x, y, z) - domain.min)] = value(glm::ivec3(x, y, z) - origin);
  };
  for (const Tile& tile : field.tiles)
    fill(tile.origin, tile.width, [&](const glm::ivec3&) { return tile.value.x; });
  for (const Leaf& leaf : field.leaves)
    fill(leaf.origin, 8,
         [&](const glm::ivec3& at) { return leaf.values[(at.x * 8 + at.y) * 8 + at.z]; });

  glCreateTextures(GL_TEXTURE_3D, 1, &volume_);
  glTextureStorage3D(volume_, 1, GL_R32F, size.z, size.y, size.x);
  glTextureParameteri(volume_, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(volume_, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureSubImage3D(volume_, 0, 0, 0, 0, size.z, size.y, size.x, GL_RED, GL_FLOAT, values.data());
  glCreateVertexArrays(1, &vertex_array_);
  context_.check("copying the dense volume");
}

DenseRenderer::~DenseRenderer() {
  context_.make_current();
  glDeleteTextures(1, &volume_);
  glDeleteVertexArrays(1, &vertex_array_);
}

double DenseRenderer::render(const View& view, const MediumAtlas& atlas) {
  context_.make_current();
  const MarchSetup setup = make_march_setup(view, atlas);
  const std::string prelude = gl::common_prelude(gl::driver_is_software()) +
#define GRID(id, name) "const int " #name "_buffers = 1;\n"
#include "grids.glsl"
#undef GRID
                              "const int texels_per_buffer = 1;\n"
                              "#define HARDWARE_FILTER " +
                              std::to_string(setup.constants.hardware_filter) +
                              "\n#define LUMINANCE_DENSITY " +
                              std::to_string(view.medium.source == LuminanceSource::density) + "\n";
  auto& program = programs_[prelude];
  if (!program)
    program = std::make_unique<gl::Program>(
        "dense.frag", prelude, std::map<std::string, std::string>{{"dense.frag", dense_shader}});
  gl::set_parameters(*program, setup.parameters);
  program->set("tile_origin", glm::ivec2(0));
  program->set("volume", 0);

  const glm::ivec2 size = view.scene.resolution;
  const Stopwatch watch;
  target_.bind(0);
  glBindTextureUnit(0, volume_);
  glBindVertexArray(vertex_array_);
  glUseProgram(program->id());
  glViewport(0, 0, size.x, size.y);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  std::vector<glm::vec4> picture(std::size_t(size.x) * std::size_t(size.y));
  target_.read_picture(size.x, size.y, picture.data(), size.x);
  context_.check("drawing the dense volume");
  return watch.ms();
}

}  // namespace psivox::bench
