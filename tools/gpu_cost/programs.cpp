#include "programs.h"

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>
#include <algorithm>
#include <spirv-tools/optimizer.hpp>
#include <stdexcept>

#include "gl/march_source.h"
#include "march/atlas_march.h"
#include "march/film.h"
#include "march/march_double.h"

namespace psivox::gpu_cost {

const std::vector<Listed>& listed_programs() {
  static const std::vector<Listed> list = {
      {"cells, constant L", R"("sampling": "cells")", 48},
      {"cells, L from density", R"("sampling": "cells", "luminance-grid": "density")", 56},
      {"cell-exact, L from density", R"("integrator": "cell-exact", "luminance-grid": "density")",
       48},
      {"cell-exact, function with shells",
       R"("integrator": "cell-exact", "transfer-function": "shells.json", "split-knots": true)",
       64},
      {"cell-exact, three grids",
       R"("integrator": "cell-exact", "luminance-grid": "color", "emission-grid": "temperature")",
       152},
      {"uniform, psi-balanced, constant L", R"("step": 1)", 48},
      {"uniform, psi-balanced, L from density", R"("step": 1, "luminance-grid": "density")", 56},
      {"uniform, function with shells", R"("step": 1, "transfer-function": "shells.json")", 64},
      {"uniform, lit", R"("step": 1, "light": [1, -1, 0])", 88},
      {"tolerance 1e-3, lit", R"("tolerance": 1e-3, "light": [1, -1, 0])", 80},
      {"tolerance 1e-3, fire", R"("tolerance": 1e-3, "temperature-grid": "temperature")", 96},
      {"MIP", R"("mode": "mip", "sampling": "cells")", 64},
      {"isosurface", R"("mode": "isosurface", "sampling": "cells")", 56},
      {"rays towards a light", R"("step": 1, "light": [1, -1, 0], "light-quality": "exact")", 48,
       "light.frag"},
  };
  return list;
}

namespace {

constexpr int block = 8;         ///< side of the pixels of a wave
constexpr int block_place = 16;  ///< one of so many blocks along each axis is counted

RayCounts count_rays(MarchSetup setup, const MediumAtlas& atlas, const glm::ivec2& size) {
  setup.constants.passes_octants = false;
  glsl::AtlasMarch march(setup, atlas);
  RayCounts sums;
  int blocks = 0;
  for (int y = block * block_place / 2; y < size.y; y += block * block_place)
    for (int x = block * block_place / 2; x < size.x; x += block * block_place) {
      int longest = 0;
      for (int i = 0; i < block * block; ++i) {
        const auto m = march.march_ray(glm::dvec2(x + i % block, y + i / block));
        longest = std::max(longest, m.turns);
        sums.turns += m.turns;
        sums.look_ups += m.samples;
      }
      sums.wave_turns += longest;
      ++blocks;
    }
  const double rays = double(blocks) * block * block;
  return {sums.turns / rays, sums.wave_turns / blocks, sums.look_ups / rays};
}

/// A marcher that writes down the programs which it is asked to run. Its light is the march's in
/// double, so that what follows from it is chosen as on a GPU.
class Recorder : public Marcher {
 public:
  explicit Recorder(bool counts) : counts_(counts) {}

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
    RenderOptions counted = options;
    counted.count = counts_;
    add(make_march_setup(view, *atlas_, options), "march.frag");
    if (counts_)
      programs.back().rays =
          count_rays(make_march_setup(view, *atlas_, counted), *atlas_, view.scene.resolution);
    RenderResult result;
    result.image = Film(view, options).finish(result.stats);
    return result;
  }

  std::vector<Program> programs;

 private:
  void add(MarchSetup setup, const std::string& shader) {
    setup.constants.passes_octants = false;
    PerGrid<int> buffers{};
    const auto grids = grids_of(*atlas_);
    for (std::size_t i = 0; i < grids.size(); ++i)
      buffers[i] = grids[i] && !(setup.constants.paired && i == luminance_grid);
    gl::ProgramKey key = gl::program_key(setup, buffers);
    programs.push_back({shader, gl::march_source(key, shader, false).text});
  }

  bool counts_;
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

std::vector<Program> programs_of(const Scene& scene, bool count_rays) {
  const auto recorder = std::make_shared<Recorder>(count_rays);
  Session(scene).draw(*recorder, {.confirm = false});
  return std::move(recorder->programs);
}

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
