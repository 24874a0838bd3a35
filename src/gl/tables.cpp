#include "gl/tables.h"

#include <string>

#include "psivox/error.h"

namespace psivox::gl {

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
