#include "null_device.h"

#include <array>
#include <cstdlib>
#include <cstring>
#include <map>
#include <stdexcept>

namespace psivox::gpu_cost {
namespace {

void check(VkResult result, const char* what) {
  if (result < 0)
    throw std::runtime_error(std::string(what) + " failed: " + std::to_string(result));
}

template <typename T>
T get(VkDevice device, const char* name) {
  const auto function = reinterpret_cast<T>(vkGetDeviceProcAddr(device, name));
  if (!function) throw std::runtime_error(std::string("the driver has no ") + name);
  return function;
}

VkDescriptorType descriptor_type(Binding::Kind kind) {
  switch (kind) {
    case Binding::Kind::texel_buffer:
      return VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    case Binding::Kind::image:
      return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    case Binding::Kind::uniforms:
      break;
  }
  return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
}

VkShaderModule make_module(VkDevice device, const std::vector<std::uint32_t>& code) {
  VkShaderModuleCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  info.codeSize = code.size() * sizeof code[0];
  info.pCode = code.data();
  VkShaderModule module{};
  check(vkCreateShaderModule(device, &info, nullptr, &module), "vkCreateShaderModule");
  return module;
}

constexpr int targets = 6;  // a picture, layers, four of state
constexpr std::array<VkFormat, targets> target_formats{
    VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_R32G32B32A32_SINT,
    VK_FORMAT_R32G32B32A32_SINT,   VK_FORMAT_R32G32B32A32_SINT,   VK_FORMAT_R32G32B32A32_SINT};

/// The fixed state of a pipeline that draws one triangle over its targets.
struct FixedState {
  VkPipelineVertexInputStateCreateInfo vertices{};
  VkPipelineInputAssemblyStateCreateInfo assembly{};
  VkPipelineViewportStateCreateInfo viewport{};
  VkPipelineRasterizationStateCreateInfo raster{};
  VkPipelineMultisampleStateCreateInfo samples{};
  std::array<VkPipelineColorBlendAttachmentState, targets> attachments{};
  VkPipelineColorBlendStateCreateInfo blend{};
  std::array<VkDynamicState, 2> dynamics{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  VkPipelineDynamicStateCreateInfo dynamic{};
  VkPipelineRenderingCreateInfo rendering{};

  FixedState() {
    vertices.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO;
    assembly.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO;
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    viewport.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO;
    viewport.viewportCount = viewport.scissorCount = 1;
    raster.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO;
    raster.lineWidth = 1;
    samples.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO;
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    for (auto& attachment : attachments) attachment.colorWriteMask = 0xf;
    blend.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO;
    blend.attachmentCount = targets;
    blend.pAttachments = attachments.data();
    dynamic.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO;
    dynamic.dynamicStateCount = std::uint32_t(dynamics.size());
    dynamic.pDynamicStates = dynamics.data();
    rendering.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO;
    rendering.colorAttachmentCount = targets;
    rendering.pColorAttachmentFormats = target_formats.data();
  }
};

VkPipeline make_pipeline(VkDevice device, VkShaderModule vertex, VkShaderModule fragment,
                         VkPipelineLayout layout) {
  std::array<VkPipelineShaderStageCreateInfo, 2> stages{};
  for (auto& stage : stages) {
    stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    stage.pName = "main";
  }
  stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
  stages[0].module = vertex;
  stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
  stages[1].module = fragment;
  const FixedState state;
  VkGraphicsPipelineCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO;
  info.pNext = &state.rendering;
  info.flags = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR |
               VK_PIPELINE_CREATE_CAPTURE_INTERNAL_REPRESENTATIONS_BIT_KHR;
  info.stageCount = std::uint32_t(stages.size());
  info.pStages = stages.data();
  info.pVertexInputState = &state.vertices;
  info.pInputAssemblyState = &state.assembly;
  info.pViewportState = &state.viewport;
  info.pRasterizationState = &state.raster;
  info.pMultisampleState = &state.samples;
  info.pColorBlendState = &state.blend;
  info.pDynamicState = &state.dynamic;
  info.layout = layout;
  VkPipeline pipeline{};
  check(vkCreateGraphicsPipelines(device, nullptr, 1, &info, nullptr, &pipeline),
        "vkCreateGraphicsPipelines");
  return pipeline;
}

VkPipelineExecutableInfoKHR executable(VkPipeline pipeline, std::uint32_t index) {
  VkPipelineExecutableInfoKHR info{};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR;
  info.pipeline = pipeline;
  info.executableIndex = index;
  return info;
}

/// All that a function of Vulkan lists: it is asked for their number, then for so many.
template <typename T, typename F>
std::vector<T> listed(const F& list, VkStructureType type) {
  std::uint32_t count = 0;
  list(&count, static_cast<T*>(nullptr));
  T empty{};
  empty.sType = type;
  std::vector<T> all(count, empty);
  list(&count, all.data());
  return all;
}

std::uint32_t fragment_index(VkDevice device, VkPipeline pipeline) {
  VkPipelineInfoKHR info{};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR;
  info.pipeline = pipeline;
  const auto properties =
      get<PFN_vkGetPipelineExecutablePropertiesKHR>(device, "vkGetPipelineExecutablePropertiesKHR");
  const auto all = listed<VkPipelineExecutablePropertiesKHR>(
      [&](std::uint32_t* count, auto* out) { properties(device, &info, count, out); },
      VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR);
  for (std::uint32_t i = 0; i < all.size(); ++i)
    if (all[i].stages & VK_SHADER_STAGE_FRAGMENT_BIT) return i;
  throw std::runtime_error("the pipeline has no fragment shader");
}

std::map<std::string, int> numbers_of(VkDevice device, const VkPipelineExecutableInfoKHR& info) {
  const auto read =
      get<PFN_vkGetPipelineExecutableStatisticsKHR>(device, "vkGetPipelineExecutableStatisticsKHR");
  std::map<std::string, int> numbers;
  for (const auto& s : listed<VkPipelineExecutableStatisticKHR>(
           [&](std::uint32_t*count, auto*out) { read(device, &info, count, out); },
           VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR))
    numbers[s.name] = int(s.value.u64);
  return numbers;
}

std::string assembly_of(VkDevice device, const VkPipelineExecutableInfoKHR& info) {
  const auto read = get<PFN_vkGetPipelineExecutableInternalRepresentationsKHR>(
      device, "vkGetPipelineExecutableInternalRepresentationsKHR");
  auto all = listed<VkPipelineExecutableInternalRepresentationKHR>(
      [&](std::uint32_t* count, auto* out) { read(device, &info, count, out); },
      VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INTERNAL_REPRESENTATION_KHR);
  auto count = std::uint32_t(all.size());
  std::vector<std::string> texts(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    texts[i].resize(all[i].dataSize);
    all[i].pData = texts[i].data();
  }
  read(device, &info, &count, all.data());
  for (std::uint32_t i = 0; i < count; ++i)
    if (std::string(all[i].name) == "Assembly") return texts[i].c_str();
  throw std::runtime_error("the driver shows no assembly");
}

}  // namespace

NullDevice::NullDevice(const std::string& family) {
  setenv("RADV_FORCE_FAMILY", family.c_str(), 1);
  VkApplicationInfo application{};
  application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
  application.apiVersion = VK_API_VERSION_1_3;
  VkInstanceCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  info.pApplicationInfo = &application;
  check(vkCreateInstance(&info, nullptr, &instance_), "vkCreateInstance");
  try {
    choose_device();
    open_device();
  } catch (...) {
    vkDestroyInstance(instance_, nullptr);
    throw;
  }
}

void NullDevice::choose_device() {
  std::uint32_t count = 0;
  check(vkEnumeratePhysicalDevices(instance_, &count, nullptr), "vkEnumeratePhysicalDevices");
  std::vector<VkPhysicalDevice> all(count);
  check(vkEnumeratePhysicalDevices(instance_, &count, all.data()), "vkEnumeratePhysicalDevices");
  for (const VkPhysicalDevice device : all) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(device, &properties);
    if (std::strstr(properties.deviceName, "Null hardware")) physical_ = device;
  }
  if (!physical_) throw std::runtime_error("RADV is not installed (Debian: mesa-vulkan-drivers)");
}

void NullDevice::open_device() {
  const float priority = 1;
  VkDeviceQueueCreateInfo queue{};
  queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR executables{};
  executables.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR;
  executables.pipelineExecutableInfo = VK_TRUE;
  VkPhysicalDeviceVulkan13Features features{};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
  features.pNext = &executables;
  features.dynamicRendering = VK_TRUE;
  const char* extension = VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME;
  VkDeviceCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  info.pNext = &features;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.enabledExtensionCount = 1;
  info.ppEnabledExtensionNames = &extension;
  check(vkCreateDevice(physical_, &info, nullptr, &device_), "vkCreateDevice");
}

NullDevice::~NullDevice() {
  vkDestroyDevice(device_, nullptr);
  vkDestroyInstance(instance_, nullptr);
}

VkPipelineLayout NullDevice::make_layout(const Module& fragment, VkDescriptorSetLayout& set) const {
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (const Binding& b : fragment.bindings)
    bindings.push_back(
        {b.number, descriptor_type(b.kind), b.count, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr});
  VkDescriptorSetLayoutCreateInfo set_info{};
  set_info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
  set_info.bindingCount = std::uint32_t(bindings.size());
  set_info.pBindings = bindings.data();
  check(vkCreateDescriptorSetLayout(device_, &set_info, nullptr, &set),
        "vkCreateDescriptorSetLayout");
  VkPipelineLayoutCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  info.setLayoutCount = 1;
  info.pSetLayouts = &set;
  VkPipelineLayout layout{};
  check(vkCreatePipelineLayout(device_, &info, nullptr, &layout), "vkCreatePipelineLayout");
  return layout;
}

Compiled NullDevice::compile(const Module& vertex, const Module& fragment) const {
  VkDescriptorSetLayout set{};
  const VkPipelineLayout layout = make_layout(fragment, set);
  const VkShaderModule modules[] = {make_module(device_, vertex.code),
                                    make_module(device_, fragment.code)};
  const VkPipeline pipeline = make_pipeline(device_, modules[0], modules[1], layout);
  const Compiled compiled = statistics(pipeline);
  vkDestroyPipeline(device_, pipeline, nullptr);
  for (const VkShaderModule module : modules) vkDestroyShaderModule(device_, module, nullptr);
  vkDestroyPipelineLayout(device_, layout, nullptr);
  vkDestroyDescriptorSetLayout(device_, set, nullptr);
  return compiled;
}

Compiled NullDevice::statistics(VkPipeline pipeline) const {
  const auto info = executable(pipeline, fragment_index(device_, pipeline));
  const auto numbers = numbers_of(device_, info);
  Compiled c;
  c.registers = numbers.at("VGPRs");
  c.scalar_registers = numbers.at("SGPRs");
  c.spills = numbers.at("Spilled VGPRs") + numbers.at("Spilled SGPRs");
  c.waves = numbers.at("Subgroups per SIMD");
  c.instructions = numbers.at("Instructions");
  c.branches = numbers.at("Branches");
  c.code_bytes = numbers.at("Code size");
  c.latency = numbers.at("Latency");
  c.inverse_throughput = numbers.at("Inverse Throughput");
  c.assembly = assembly_of(device_, info);
  return c;
}

}  // namespace psivox::gpu_cost
