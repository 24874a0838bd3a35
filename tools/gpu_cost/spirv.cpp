#include "spirv.h"

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include <spirv-tools/optimizer.hpp>
#include <stdexcept>

namespace psivox::gpu_cost {
namespace {

/// glslang's state of a process.
struct Glslang {
  Glslang() { glslang::InitializeProcess(); }
  ~Glslang() { glslang::FinalizeProcess(); }
};

[[noreturn]] void fail(const std::string& log) {
  throw std::runtime_error(log.substr(0, log.find('\n')));
}

Binding::Kind kind_of(const glslang::TType& type) {
  if (type.getBasicType() != glslang::EbtSampler) return Binding::Kind::uniforms;
  return type.getSampler().isBuffer() ? Binding::Kind::texel_buffer : Binding::Kind::image;
}

std::vector<Binding> bindings_of(glslang::TProgram& program) {
  program.buildReflection(EShReflectionDefault);
  std::vector<Binding> bindings;
  const auto add = [&](const glslang::TObjectReflection& object, Binding::Kind kind) {
    if (object.getBinding() < 0) return;  // a member of a block
    const auto* type = object.getType();
    const std::uint32_t count = type->isArray() ? std::uint32_t(type->getOuterArraySize()) : 1;
    bindings.push_back({std::uint32_t(object.getBinding()), kind, count});
  };
  for (int i = 0; i < program.getNumUniformVariables(); ++i)
    add(program.getUniform(i), kind_of(*program.getUniform(i).getType()));
  for (int i = 0; i < program.getNumUniformBlocks(); ++i)
    add(program.getUniformBlock(i), Binding::Kind::uniforms);
  return bindings;
}

}  // namespace

Module module_from_glsl(const std::string& text, ShaderStage stage, bool optimised) {
  static const Glslang glslang_of_process;
  const EShLanguage language = stage == ShaderStage::vertex ? EShLangVertex : EShLangFragment;
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

}  // namespace psivox::gpu_cost
