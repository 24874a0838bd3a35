#pragma once

#include <vulkan/vulkan.h>

#include <string>

#include "programs.h"

namespace psivox::gpu_cost {

/// What the driver's compiler says of a pipeline's fragment shader.
struct Compiled {
  int registers = 0;         ///< vector registers of a thread
  int scalar_registers = 0;  ///< of a wave
  int spills = 0;            ///< registers kept in memory, of both kinds
  int waves = 0;             ///< that a SIMD holds at a time
  int instructions = 0;
  int branches = 0;
  int code_bytes = 0;
  int latency = 0;             ///< of a wave, estimated [clocks]
  int inverse_throughput = 0;  ///< estimated [clocks a wave]
  std::string assembly;
};

/// RADV's compiler for an AMD GPU that need not be there (RADV_FORCE_FAMILY).
class NullDevice {
 public:
  /// `family`: as RADV names it, navi21. Throws std::runtime_error where there is no RADV.
  explicit NullDevice(const std::string& family);
  ~NullDevice();
  NullDevice(const NullDevice&) = delete;
  NullDevice& operator=(const NullDevice&) = delete;

  /// A pipeline that draws four targets without vertices, from that shader.
  Compiled compile(const Module& vertex, const Module& fragment) const;

 private:
  void choose_device();
  void open_device();
  VkPipelineLayout make_layout(const Module& fragment, VkDescriptorSetLayout& set) const;
  Compiled statistics(VkPipeline pipeline) const;

  VkInstance instance_ = nullptr;
  VkPhysicalDevice physical_ = nullptr;
  VkDevice device_ = nullptr;
};

}  // namespace psivox::gpu_cost
