// gpu_cost [--assets DIR] [--check]: what psivox's programs cost on GPUs, without one: RADV
// compiles them for AMD's. Prints a table of listed programs. --check prints nothing but faults: a
// program that glslang refuses, spills, or registers far above the list's.
#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <spirv-tools/optimizer.hpp>
#include <stdexcept>
#include <string>
#include <vector>
#include <vulkan/vulkan_raii.hpp>

#include "base/stopwatch.h"
#include "gl/march_program.h"
#include "march/film.h"
#include "march/march_double.h"
#include "psivox/draw.h"
#include "psivox/parameters.h"

namespace {

using namespace psivox;

constexpr int skipped = 77;        // ctest's code for a test that cannot run here
constexpr int free_binding = 31;   // which no image or texture takes
constexpr int more_registers = 8;  // than the list's are allowed: one granule of the hardware's
const char* const families[] = {"navi21", "gfx1100"};

/// A scene over assets/blobs.vdb whose program for the picture is measured.
struct Listed {
  std::string name;
  std::string scene;  ///< JSON, as --scene reads it; transfer functions by their names in assets/
  int registers = 0;  ///< least so far, passing over octants: vector registers on navi21
  std::string shader = "march.frag";
};

const Listed listed_programs[] = {
    {"cells, constant L", R"("sampling": "cells")", 40},
    {"cells, L from density", R"("sampling": "cells", "luminance-grid": "density")", 48},
    {"cell-exact, L from density", R"("integrator": "cell-exact", "luminance-grid": "density")",
     48},
    {"cell-exact, function with shells",
     R"("integrator": "cell-exact", "transfer-function": "shells.json", "split-knots": true)", 64},
    {"cell-exact, three grids",
     R"("integrator": "cell-exact", "luminance-grid": "color", "emission-grid": "temperature")",
     112},
    {"uniform, psi-balanced, constant L", R"("step": 1)", 48},
    {"uniform, psi-balanced, L from density", R"("step": 1, "luminance-grid": "density")", 48},
    {"uniform, function with shells", R"("step": 1, "transfer-function": "shells.json")", 64},
    {"uniform, lit", R"("step": 1, "light": [1, -1, 0])", 64},
    {"cells, codes", R"("sampling": "cells", "texel": "code12")", 48},
    {"uniform, lit, codes", R"("step": 1, "light": [1, -1, 0], "texel": "code12")", 72},
    {"tolerance 1e-3, lit", R"("tolerance": 1e-3, "light": [1, -1, 0])", 64},
    {"tolerance 1e-3, fire", R"("tolerance": 1e-3, "temperature-grid": "temperature")", 80},
    {"MIP", R"("mode": "mip", "sampling": "cells")", 48},
    {"isosurface", R"("mode": "isosurface", "sampling": "cells")", 56},
    {"rays towards a light", R"("step": 1, "light": [1, -1, 0], "light-quality": "exact")", 40,
     "light.frag"},
};

// --- programs

/// A marcher that writes down the programs which it is asked to run. Its light is the march's in
/// double, so that what follows from it is chosen as on a GPU.
class Recorder : public Marcher {
 public:
  std::string description() const override { return "a GPU that is not there"; }
  void upload(const MediumAtlas& atlas, Filter) override { atlas_ = &atlas; }

  LightDepths light_depths(const View& view) override {
    return [this, &view, depths = march_double_light_depths(view, *atlas_)](
               std::span<const Beam> beams, LightBlocks blocks, const TakeLight& take,
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

  std::map<std::string, std::string> programs;  ///< GLSL as a GPU's driver gets it, by its shader

 private:
  void add(MarchSetup setup, const std::string& shader) {
    PerGrid<int> buffers{};
    const auto grids = grids_of(*atlas_);
    for (std::size_t i = 0; i < grids.size(); ++i)
      buffers[i] = grids[i] && !(setup.constants.paired && i == luminance_grid);
    gl::ProgramKey key = gl::program_key(setup, buffers);
    programs.emplace(shader, gl::march_source(key, shader, {.computes = true}).text);
  }

  const MediumAtlas* atlas_ = nullptr;
};

/// The GLSL of a listed program, found among the programs that a GPU would draw its scene with.
std::string text_of(const Listed& listed, const std::filesystem::path& assets) {
  Scene scene = scene_from_json("{" + listed.scene + "}");
  scene.input = (assets / "blobs.vdb").string();
  if (!scene.transfer_function.empty())
    scene.transfer_function = (assets / scene.transfer_function).string();
  scene.resolution = {64, 64};
  Recorder recorder;
  Session(scene).draw(recorder, {.confirm = false});
  return recorder.programs.at(listed.shader);
}

/// A shader for Vulkan.
struct Module {
  std::vector<std::uint32_t> code;  ///< SPIR-V
  std::vector<vk::DescriptorSetLayoutBinding> bindings;
};

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
                      : type.getSampler().isImage()              ? Type::eStorageImage
                      : type.getSampler().isBuffer()             ? Type::eUniformTexelBuffer
                                                                 : Type::eCombinedImageSampler;
    bindings.emplace_back(std::uint32_t(object.getBinding()), kind,
                          type.isArray() ? std::uint32_t(type.getOuterArraySize()) : 1,
                          vk::ShaderStageFlagBits::eCompute);
  };
  for (int i = 0; i < program.getNumUniformVariables(); ++i) add(program.getUniform(i));
  for (int i = 0; i < program.getNumUniformBlocks(); ++i) add(program.getUniformBlock(i));
  return bindings;
}

/// Compiles OpenGL's GLSL by glslang: its uniforms become a block, and bindings are numbered.
/// `optimised`: by spirv-opt's passes for performance. Throws std::runtime_error with the
/// compiler's first message.
Module module_from_glsl(const std::string& text, bool optimised = true) {
  static const Glslang glslang_of_process;
  const auto messages = EShMessages(EShMsgSpvRules | EShMsgVulkanRules);
  glslang::TShader shader(EShLangCompute);
  const char* texts[] = {text.c_str()};
  shader.setStrings(texts, 1);
  shader.setEnvInput(glslang::EShSourceGlsl, EShLangCompute, glslang::EShClientVulkan, 100);
  shader.setEnvInputVulkanRulesRelaxed();
  shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_3);
  shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_6);
  shader.setAutoMapBindings(true);
  shader.setGlobalUniformBlockName("default_block");
  shader.setGlobalUniformBinding(free_binding);
  if (!shader.parse(GetDefaultResources(), 450, false, messages)) fail(shader.getInfoLog());
  glslang::TProgram program;
  program.addShader(&shader);
  if (!program.link(messages) || !program.mapIO()) fail(program.getInfoLog());

  Module module;
  glslang::GlslangToSpv(*program.getIntermediate(EShLangCompute), module.code);
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

// --- RADV

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
    const vk::StructureChain chain(vk::DeviceCreateInfo({}, queue, {}, extension),
                                   vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR(true));
    return {device, chain.get<>()};
  }
  throw std::runtime_error("RADV is not installed (Debian: mesa-vulkan-drivers)");
}

/// What the driver's compiler says of a program, by its own names.
using Statistics = std::map<std::string, int>;

/// RADV's compiler for an AMD GPU that need not be there (RADV_FORCE_FAMILY).
class NullDevice {
 public:
  /// `family`: as RADV names it, navi21. Throws std::runtime_error where there is no RADV.
  explicit NullDevice(const std::string& family)
      : instance_(open_instance(context_, family)), device_(open_device(instance_)) {}

  Statistics compile(const Module& module) const {
    const vk::raii::DescriptorSetLayout set(device_, {{}, module.bindings});
    const vk::raii::PipelineLayout layout(device_, {{}, *set});
    const vk::raii::ShaderModule shader(device_, {{}, module.code});
    const vk::raii::Pipeline pipeline(
        device_, nullptr,
        vk::ComputePipelineCreateInfo(vk::PipelineCreateFlagBits::eCaptureStatisticsKHR,
                                      {{}, vk::ShaderStageFlagBits::eCompute, *shader, "main"},
                                      *layout));
    const vk::PipelineExecutableInfoKHR info(*pipeline);  // its only program
    Statistics statistics;
    for (const auto& number : device_.getPipelineExecutableStatisticsKHR(info))
      statistics[number.name] = int(number.value.u64);
    return statistics;
  }

 private:
  vk::raii::Context context_;
  vk::raii::Instance instance_;
  vk::raii::Device device_;
};

int spills_of(const Statistics& s) { return s.at("Spilled VGPRs") + s.at("Spilled SGPRs"); }

// --- the table, and the test

void print_row(const Listed& listed, const std::string& text, const NullDevice& device) {
  const Statistics s = device.compile(module_from_glsl(text));
  const Module unchanged = module_from_glsl(text, false);
  const Stopwatch building;
  const Statistics plain = device.compile(unchanged);
  std::printf("| %s | %d | %d | %d | %d | %d | %d | %d | %.0f |\n", listed.name.c_str(),
              s.at("VGPRs"), spills_of(s), s.at("Subgroups per SIMD"), s.at("Instructions"),
              s.at("Branches"), s.at("Inverse Throughput"), plain.at("VGPRs"), building.cpu_ms());
}

void print_table(const std::filesystem::path& assets) {
  std::vector<std::string> texts;
  for (const Listed& listed : listed_programs) texts.push_back(text_of(listed, assets));
  for (const char* family : families) {
    const NullDevice device(family);
    std::printf(
        "\n%s\n\n| program | VGPRs | spills | waves per SIMD | instructions | branches | inverse "
        "throughput | plain: VGPRs | build [ms] |\n|---|---|---|---|---|---|---|---|---|\n",
        family);
    for (std::size_t i = 0; i < texts.size(); ++i) print_row(listed_programs[i], texts[i], device);
  }
}

/// Prints the faults of the listed programs; returns their number.
int check_programs(const NullDevice& device, const std::filesystem::path& assets) {
  int faults = 0;
  for (const Listed& listed : listed_programs) {
    std::string fault;
    try {
      const Statistics s = device.compile(module_from_glsl(text_of(listed, assets)));
      if (spills_of(s)) fault = std::to_string(spills_of(s)) + " registers are spilled";
      if (s.at("VGPRs") > listed.registers + more_registers)
        fault = std::to_string(s.at("VGPRs")) + " registers, " + std::to_string(listed.registers) +
                " were enough before";
    } catch (const std::exception& error) {
      fault = error.what();
    }
    if (fault.empty()) continue;
    std::printf("%s: %s\n", listed.name.c_str(), fault.c_str());
    ++faults;
  }
  return faults;
}

int check_all(const std::filesystem::path& assets) {
  std::optional<NullDevice> device;
  try {
    device.emplace(families[0]);
  } catch (const std::runtime_error& error) {
    std::printf("skipped: %s\n", error.what());
    return skipped;
  }
  return check_programs(*device, assets) ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::string assets = "assets";
  bool check = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--check") {
      check = true;
    } else if (argument == "--assets" && i + 1 < argc) {
      assets = argv[++i];
    } else {
      std::fprintf(stderr, "usage: gpu_cost [--assets DIR] [--check]\n");
      return 2;
    }
  }
  try {
    if (check) return check_all(assets);
    print_table(assets);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gpu_cost: %s\n", error.what());
    return 1;
  }
  return 0;
}
