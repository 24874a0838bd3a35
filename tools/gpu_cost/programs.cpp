#include "programs.h"

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <spirv-tools/optimizer.hpp>
#include <stdexcept>

#include "gl/march_program.h"
#include "march/film.h"
#include "march/march_double.h"

namespace psivox::gpu_cost {

const std::vector<Listed>& listed_programs() {
  static const std::vector<Listed> list = {
      {"cells, constant L", R"("sampling": "cells")", 64},
      {"cells, L from density", R"("sampling": "cells", "luminance-grid": "density")", 64},
      {"cell-exact, L from density", R"("integrator": "cell-exact", "luminance-grid": "density")",
       64},
      {"cell-exact, function with shells",
       R"("integrator": "cell-exact", "transfer-function": "shells.json", "split-knots": true)",
       80},
      {"cell-exact, three grids",
       R"("integrator": "cell-exact", "luminance-grid": "color", "emission-grid": "temperature")",
       160},
      {"uniform, psi-balanced, constant L", R"("step": 1)", 64},
      {"uniform, psi-balanced, L from density", R"("step": 1, "luminance-grid": "density")", 72},
      {"uniform, function with shells", R"("step": 1, "transfer-function": "shells.json")", 80},
      {"uniform, lit", R"("step": 1, "light": [1, -1, 0])", 96},
      {"cells, boxes of codes", R"("sampling": "cells", "texel": "code12")", 64},
      {"uniform, lit, boxes of codes", R"("step": 1, "light": [1, -1, 0], "texel": "code12")", 104},
      {"tolerance 1e-3, lit", R"("tolerance": 1e-3, "light": [1, -1, 0])", 104},
      {"tolerance 1e-3, fire", R"("tolerance": 1e-3, "temperature-grid": "temperature")", 112},
      {"MIP", R"("mode": "mip", "sampling": "cells")", 64},
      {"isosurface", R"("mode": "isosurface", "sampling": "cells")", 72},
      {"rays towards a light", R"("step": 1, "light": [1, -1, 0], "light-quality": "exact")", 56,
       "light.frag"},
  };
  return list;
}

namespace {

/// A marcher that writes down the programs which it is asked to run. Its light is the march's in
/// double, so that what follows from it is chosen as on a GPU.
class Recorder : public Marcher {
 public:
  std::string description() const override { return "a GPU that is not there"; }
  void upload(const MediumAtlas& atlas, Filter) override { atlas_ = &atlas; }

  LightDepths light_depths(const View& view) override {
    return [this, &view, depths = march_double_light_depths(view, *atlas_)](
               std::span<const Beam> beams, const LightBlocks& blocks, const TakeLight& take,
               const Progress& progress) {
      for (const Beam& beam : beams) {
        if (beam.method.spacing == 0)
          add(make_march_setup(light_march(view, beam), *atlas_), "light.frag");
      }
      depths(beams, blocks, take, progress);
    };
  }

  RenderResult render(const View& view, const RenderOptions& options) override {
    add(make_march_setup(view, *atlas_, options), "march.frag");
    RenderResult result;
    result.image = Film(view, options).finish(result.stats);
    return result;
  }

  std::vector<Program> programs;

 private:
  void add(MarchSetup setup, const std::string& shader) {
    PerGrid<int> buffers{};
    const auto grids = grids_of(*atlas_);
    for (std::size_t i = 0; i < grids.size(); ++i)
      buffers[i] = grids[i] && !(setup.constants.paired && i == luminance_grid);
    gl::ProgramKey key = gl::program_key(setup, buffers);
    programs.push_back({shader, gl::march_source(key, shader).text});
  }

  const MediumAtlas* atlas_ = nullptr;
};

/// glslang's state of a process.
struct Glslang {
  Glslang() { glslang::InitializeProcess(); }
  ~Glslang() { glslang::FinalizeProcess(); }
};

[[noreturn]] void fail(const std::string& log) {
  throw std::runtime_error(log.substr(0, log.find('\n')));
}

std::vector<vk::DescriptorSetLayoutBinding> bindings_of(glslang::TProgram& program) {
  using Type = vk::DescriptorType;
  program.buildReflection(EShReflectionDefault);
  std::vector<vk::DescriptorSetLayoutBinding> bindings;
  const auto add = [&](const glslang::TObjectReflection& object) {
    if (object.getBinding() < 0) return;  // a member of a block
    const glslang::TType& type = *object.getType();
    const Type kind = type.getBasicType() != glslang::EbtSampler ? Type::eUniformBuffer
                      : type.getSampler().isBuffer()             ? Type::eUniformTexelBuffer
                                                                 : Type::eCombinedImageSampler;
    bindings.emplace_back(std::uint32_t(object.getBinding()), kind,
                          type.isArray() ? std::uint32_t(type.getOuterArraySize()) : 1,
                          vk::ShaderStageFlagBits::eFragment);
  };
  for (int i = 0; i < program.getNumUniformVariables(); ++i) add(program.getUniform(i));
  for (int i = 0; i < program.getNumUniformBlocks(); ++i) add(program.getUniformBlock(i));
  return bindings;
}

// --- RADV

// Draws without vertices.
const char* const triangle = R"(#version 450 core
void main() { gl_Position = vec4(vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4.0 - 1.0, 0, 1); })";

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

std::vector<Program> programs_of(const Scene& scene) {
  const auto recorder = std::make_shared<Recorder>();
  Session(scene).draw(*recorder, {.confirm = false});
  return std::move(recorder->programs);
}

Module module_from_glsl(const std::string& text, vk::ShaderStageFlagBits stage, bool optimised) {
  static const Glslang glslang_of_process;
  const EShLanguage language =
      stage == vk::ShaderStageFlagBits::eVertex ? EShLangVertex : EShLangFragment;
  const auto messages = EShMessages(EShMsgSpvRules | EShMsgVulkanRules);
  glslang::TShader shader(language);
  const char* texts[] = {text.c_str()};
  shader.setStrings(texts, 1);
  shader.setEnvInput(glslang::EShSourceGlsl, language, glslang::EShClientVulkan, 100);
  shader.setEnvInputVulkanRulesRelaxed();
  shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_3);
  shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_6);
  shader.setAutoMapBindings(true);
  shader.setAutoMapLocations(true);
  shader.setGlobalUniformBlockName("default_block");
  shader.setGlobalUniformBinding(0);
  if (!shader.parse(GetDefaultResources(), 450, false, messages)) fail(shader.getInfoLog());
  glslang::TProgram program;
  program.addShader(&shader);
  if (!program.link(messages) || !program.mapIO()) fail(program.getInfoLog());

  Module module;
  glslang::GlslangToSpv(*program.getIntermediate(language), module.code);
  module.bindings = bindings_of(program);
  if (optimised) {
    spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_3);
    optimizer.RegisterPerformancePasses();
    std::vector<std::uint32_t> better;
    if (!optimizer.Run(module.code.data(), module.code.size(), &better))
      throw std::runtime_error("spirv-opt refuses the module");
    module.code = std::move(better);
  }
  return module;
}

NullDevice::NullDevice(const std::string& family)
    : instance_(open_instance(context_, family)),
      device_(open_device(instance_)),
      vertex_(module_from_glsl(triangle, vk::ShaderStageFlagBits::eVertex)) {}

Compiled NullDevice::compile(const Module& fragment) const {
  const vk::raii::DescriptorSetLayout set(device_, {{}, fragment.bindings});
  const vk::raii::PipelineLayout layout(device_, {{}, *set});
  const vk::raii::ShaderModule first(device_, {{}, vertex_.code}),
      second(device_, {{}, fragment.code});
  const vk::raii::Pipeline pipeline = make_pipeline(device_, *first, *second, *layout);
  const auto programs = device_.getPipelineExecutablePropertiesKHR(*pipeline);
  const auto own = std::ranges::find_if(programs, [](const auto& program) {
    return bool(program.stages & vk::ShaderStageFlagBits::eFragment);
  });
  const vk::PipelineExecutableInfoKHR info(*pipeline, std::uint32_t(own - programs.begin()));
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
