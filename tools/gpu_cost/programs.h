#pragma once

#include <cstdint>
#include <string>
#include <vector>
#include <vulkan/vulkan_raii.hpp>

#include "march/marcher.h"
#include "psivox/draw.h"

namespace psivox::gpu_cost {

/// A scene over assets/blobs.vdb whose program for the picture is measured.
struct Listed {
  std::string name;
  std::string scene;  ///< JSON, as --scene reads it; transfer functions by their names in assets/
  int registers = 0;  ///< least so far, passing over octants: vector registers on navi21
  std::string shader = "march.frag";
};

const std::vector<Listed>& listed_programs();

struct Program {
  std::string shader;
  std::string text;  ///< GLSL, as a GPU's driver gets it
};

/// Draws a scene's picture on no device at all: returns the programs that a GPU would draw it with,
/// the picture's last.
std::vector<Program> programs_of(const Scene& scene);

/// A shader for Vulkan.
struct Module {
  std::vector<std::uint32_t> code;  ///< SPIR-V
  std::vector<vk::DescriptorSetLayoutBinding> bindings;
};

/// Compiles OpenGL's GLSL by glslang: its uniforms become a block, bindings and locations are
/// numbered. `optimised`: by spirv-opt's passes for performance. Throws std::runtime_error with the
/// compiler's first message.
Module module_from_glsl(const std::string& text, vk::ShaderStageFlagBits stage,
                        bool optimised = true);

/// What the driver's compiler says of a pipeline's fragment shader.
struct Compiled {
  int registers = 0;  ///< vector registers of a thread
  int spills = 0;     ///< registers kept in memory, vector and scalar ones
  int waves = 0;      ///< that a SIMD holds at a time
  int instructions = 0;
  int branches = 0;
  int inverse_throughput = 0;  ///< estimated [clocks a wave]
  std::string assembly;
};

/// RADV's compiler for an AMD GPU that need not be there (RADV_FORCE_FAMILY).
class NullDevice {
 public:
  /// `family`: as RADV names it, navi21. Throws std::runtime_error where there is no RADV.
  explicit NullDevice(const std::string& family);

  /// A pipeline that draws six targets without vertices, from that fragment shader.
  Compiled compile(const Module& fragment) const;

 private:
  std::string assembly(const vk::PipelineExecutableInfoKHR& info) const;

  vk::raii::Context context_;
  vk::raii::Instance instance_;
  vk::raii::Device device_;
  Module vertex_;
};

}  // namespace psivox::gpu_cost
