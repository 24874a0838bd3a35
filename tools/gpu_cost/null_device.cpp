#include "null_device.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <stdexcept>

namespace psivox::gpu_cost {
namespace {

vk::DescriptorType descriptor_type(Binding::Kind kind) {
  switch (kind) {
    case Binding::Kind::texel_buffer:
      return vk::DescriptorType::eUniformTexelBuffer;
    case Binding::Kind::image:
      return vk::DescriptorType::eCombinedImageSampler;
    case Binding::Kind::uniforms:
      break;
  }
  return vk::DescriptorType::eUniformBuffer;
}

vk::raii::Instance open_instance(const vk::raii::Context& context, const std::string& family) {
  setenv("RADV_FORCE_FAMILY", family.c_str(), 1);
  const vk::ApplicationInfo application({}, 0, {}, 0, VK_API_VERSION_1_3);
  return {context, vk::InstanceCreateInfo({}, &application)};
}

vk::raii::Device open_device(const vk::raii::Instance& instance) {
  for (const vk::raii::PhysicalDevice& device : vk::raii::PhysicalDevices(instance)) {
    const std::string name = device.getProperties().deviceName;
    if (name.find("Null hardware") == name.npos) continue;
    const float priority = 1;
    const vk::DeviceQueueCreateInfo queue({}, 0, 1, &priority);
    const char* extension = VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME;
    vk::PhysicalDeviceVulkan13Features features;
    features.dynamicRendering = true;
    const vk::StructureChain chain(vk::DeviceCreateInfo({}, queue, {}, extension), features,
                                   vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR(true));
    return {device, chain.get<>()};
  }
  throw std::runtime_error("RADV is not installed (Debian: mesa-vulkan-drivers)");
}

vk::raii::Pipeline make_pipeline(const vk::raii::Device& device, vk::ShaderModule vertex,
                                 vk::ShaderModule fragment, vk::PipelineLayout layout) {
  const std::array stages{
      vk::PipelineShaderStageCreateInfo({}, vk::ShaderStageFlagBits::eVertex, vertex, "main"),
      vk::PipelineShaderStageCreateInfo({}, vk::ShaderStageFlagBits::eFragment, fragment, "main")};
  const vk::PipelineVertexInputStateCreateInfo vertices;
  const vk::PipelineInputAssemblyStateCreateInfo assembly({}, vk::PrimitiveTopology::eTriangleList);
  const vk::PipelineViewportStateCreateInfo viewport({}, 1, nullptr, 1);
  vk::PipelineRasterizationStateCreateInfo raster;
  raster.lineWidth = 1;
  const vk::PipelineMultisampleStateCreateInfo samples;
  constexpr auto floats = vk::Format::eR32G32B32A32Sfloat, state = vk::Format::eR32G32B32A32Sint;
  const std::array targets{floats, floats, state, state, state, state};  // a picture, layers, state
  std::array<vk::PipelineColorBlendAttachmentState, targets.size()> attachments;
  for (auto& attachment : attachments)
    attachment.colorWriteMask = vk::FlagTraits<vk::ColorComponentFlagBits>::allFlags;
  const vk::PipelineColorBlendStateCreateInfo blend({}, {}, {}, attachments);
  const std::array changing{vk::DynamicState::eViewport, vk::DynamicState::eScissor};
  const vk::PipelineDynamicStateCreateInfo dynamic({}, changing);
  const vk::StructureChain chain(
      vk::GraphicsPipelineCreateInfo(
          vk::PipelineCreateFlagBits::eCaptureStatisticsKHR |
              vk::PipelineCreateFlagBits::eCaptureInternalRepresentationsKHR,
          stages, &vertices, &assembly, {}, &viewport, &raster, &samples, {}, &blend, &dynamic,
          layout),
      vk::PipelineRenderingCreateInfo(0, targets));
  return {device, nullptr, chain.get<>()};
}

}  // namespace

NullDevice::NullDevice(const std::string& family)
    : instance_(open_instance(context_, family)), device_(open_device(instance_)) {}

Compiled NullDevice::compile(const Module& vertex, const Module& fragment) const {
  std::vector<vk::DescriptorSetLayoutBinding> bindings;
  for (const Binding& b : fragment.bindings)
    bindings.emplace_back(b.number, descriptor_type(b.kind), b.count,
                          vk::ShaderStageFlagBits::eFragment);
  const vk::raii::DescriptorSetLayout set(device_, {{}, bindings});
  const vk::raii::PipelineLayout layout(device_, {{}, *set});
  const auto shader = [&](const Module& module) {
    return vk::raii::ShaderModule(device_, {{}, module.code});
  };
  return statistics(make_pipeline(device_, *shader(vertex), *shader(fragment), *layout));
}

Compiled NullDevice::statistics(const vk::raii::Pipeline& pipeline) const {
  const auto programs = device_.getPipelineExecutablePropertiesKHR(*pipeline);
  const auto fragment = std::ranges::find_if(programs, [](const auto& program) {
    return bool(program.stages & vk::ShaderStageFlagBits::eFragment);
  });
  const vk::PipelineExecutableInfoKHR info(*pipeline, std::uint32_t(fragment - programs.begin()));
  std::map<std::string, int> numbers;
  for (const auto& number : device_.getPipelineExecutableStatisticsKHR(info))
    numbers[number.name] = int(number.value.u64);
  Compiled c;
  c.registers = numbers.at("VGPRs");
  c.spills = numbers.at("Spilled VGPRs") + numbers.at("Spilled SGPRs");
  c.waves = numbers.at("Subgroups per SIMD");
  c.instructions = numbers.at("Instructions");
  c.branches = numbers.at("Branches");
  c.inverse_throughput = numbers.at("Inverse Throughput");
  c.assembly = assembly(info);
  return c;
}

/// Asks twice: for the texts' lengths, then for the texts.
std::string NullDevice::assembly(const vk::PipelineExecutableInfoKHR& info) const {
  auto all = device_.getPipelineExecutableInternalRepresentationsKHR(info);
  std::vector<std::string> texts;
  for (const auto& text : all) texts.emplace_back(text.dataSize, '\0');
  for (std::size_t i = 0; i < all.size(); ++i) all[i].pData = texts[i].data();
  auto count = std::uint32_t(all.size());
  device_.getDispatcher()->vkGetPipelineExecutableInternalRepresentationsKHR(
      *device_, &static_cast<const VkPipelineExecutableInfoKHR&>(info), &count,
      reinterpret_cast<VkPipelineExecutableInternalRepresentationKHR*>(all.data()));
  for (std::size_t i = 0; i < all.size(); ++i)
    if (std::string(all[i].name) == "Assembly") return texts[i].c_str();
  throw std::runtime_error("the driver shows no assembly");
}

}  // namespace psivox::gpu_cost
