#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace psivox::gpu_cost {

enum class ShaderStage { vertex, fragment };

/// What a shader reads at a binding of set 0.
struct Binding {
  enum class Kind { uniforms, texel_buffer, image };
  std::uint32_t number = 0;
  Kind kind = Kind::uniforms;
  std::uint32_t count = 1;  ///< of an array
};

/// A shader for Vulkan.
struct Module {
  std::vector<std::uint32_t> code;  ///< SPIR-V
  std::vector<Binding> bindings;
};

/// Compiles OpenGL's GLSL by glslang: its uniforms become a block, bindings and locations are
/// numbered. `optimised`: by spirv-opt's passes for performance. Throws std::runtime_error with the
/// compiler's first message.
Module module_from_glsl(const std::string& text, ShaderStage stage, bool optimised = true);

}  // namespace psivox::gpu_cost
