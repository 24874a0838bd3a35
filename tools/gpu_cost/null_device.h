#pragma once

#include <string>
#include <vulkan/vulkan_raii.hpp>

#include "programs.h"

namespace psivox::gpu_cost {

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

  /// A pipeline that draws six targets without vertices, from that shader.
  Compiled compile(const Module& vertex, const Module& fragment) const;

 private:
  Compiled statistics(const vk::raii::Pipeline& pipeline) const;
  std::string assembly(const vk::PipelineExecutableInfoKHR& info) const;

  vk::raii::Context context_;
  vk::raii::Instance instance_;
  vk::raii::Device device_;
};

}  // namespace psivox::gpu_cost
