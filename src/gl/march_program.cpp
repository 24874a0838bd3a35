#include "gl/march_program.h"

#include <algorithm>
#include <span>
#include <string>

#include "base/renderer_name.h"
#include "psivox/error.h"

namespace psivox::gl {

bool driver_is_software() {
  const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return renderer && is_software(renderer);
}

MarchProgram::MarchProgram(const ProgramKey& key, const std::string& shader)
    : key_(key), program_(shader, march_source(key, shader, driver_is_software())) {
  program_.set("tables", tables_unit);
  const auto set_units = [&](int grid, const std::string& name) {
    const int unit = grid_unit(grid), buffers = key.buffers[std::size_t(grid)];
    program_.set((name + "_pages").c_str(), unit);
    program_.set((name + "_constants").c_str(), unit + 1);
    program_.set((name + "_bricks").c_str(), unit + 2);
    for (int i = 0; i < std::max(buffers, 1); ++i)
      for (const char* store : {"_texels[", "_codes["})
        program_.set((name + store + std::to_string(i) + "]").c_str(), unit + 3 + i);
  };
#define GRID(id, name) set_units(id, #name);
#include "grids.glsl"
#undef GRID
}

int MarchProgram::grid_unit(int grid) const {
  int unit = first_grid_unit;
  for (int i = 0; i < grid; ++i) unit += 3 + std::max(key_.buffers[std::size_t(i)], 1);
  return unit;
}

void set_parameters(const Program& program, const MarchParameters& parameters) {
  visit_parameters(parameters, [&](const std::string& name, const auto& value) {
    program.set(name.c_str(), value);
  });
}

void MarchProgram::configure(const MarchSetup& setup) const {
  set_parameters(program_, setup.parameters);
  if (setup.constants.one_interval)
    program_.set("interval_entries",
                 std::span(setup.tables).subspan(std::size_t(setup.parameters.transfer_first), 8));
}

Tables::Tables(const std::vector<glm::vec4>& entries) {
  GLint limit = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
  if (entries.size() > std::size_t(limit))
    throw Error(ExitCode::graphics,
                "the transfer function's tables have " + std::to_string(entries.size()) +
                    " entries, and the device's textures hold " + std::to_string(limit));
  glCreateBuffers(1, &buffer_);
  glNamedBufferStorage(buffer_, GLsizeiptr(entries.size() * sizeof(glm::vec4)), entries.data(), 0);
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &texture_);
  glTextureBuffer(texture_, GL_RGBA32F, buffer_);
}

Tables::~Tables() {
  glDeleteTextures(1, &texture_);
  glDeleteBuffers(1, &buffer_);
}

}  // namespace psivox::gl
