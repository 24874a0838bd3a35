#include "gl/march_program.h"

#include <algorithm>
#include <span>
#include <sstream>
#include <string>

#include "march/glsl_subset.h"
#include "psivox/error.h"
#include "psivox/marcher.h"

namespace psivox::gl {

ProgramForm program_form() {
  const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  const bool software = renderer && is_software(renderer);
  return {.holds_uniforms = software, .computes = test_limits.computes.value_or(!software)};
}

MarchProgram::MarchProgram(const ProgramKey& key, const std::string& shader,
                           const ProgramForm& form)
    : key_(key), program_(shader, march_source(key, shader, form), form.computes) {
  program_.set("tables", tables_unit);
  const auto set_units = [&](int grid, const std::string& name) {
    const int unit = grid_unit(grid), buffers = key.buffers[std::size_t(grid)];
    program_.set((name + "_pages").c_str(), unit);
    program_.set((name + "_constants").c_str(), unit + 1);
    program_.set((name + "_bricks").c_str(), unit + 2);
    for (int i = 0; i < std::max(buffers, 1); ++i)
      for (const char* store : {"_texels[", "_codes["})
        program_.set((name + store + std::to_string(i) + "]").c_str(), unit + 3 + i);
  };
#define GRID(id, name) set_units(id, #name);
#include "grids.glsl"
#undef GRID
}

int MarchProgram::grid_unit(int grid) const {
  int unit = first_grid_unit;
  for (int i = 0; i < grid; ++i) unit += 3 + std::max(key_.buffers[std::size_t(i)], 1);
  return unit;
}

void set_parameters(const Program& program, const MarchParameters& parameters) {
  visit_parameters(parameters, [&](const std::string& name, const auto& value) {
    program.set(name.c_str(), value);
  });
}

void MarchProgram::configure(const MarchSetup& setup) const {
  set_parameters(program_, setup.parameters);
  if (setup.constants.one_interval)
    program_.set("interval_entries",
                 std::span(setup.tables).subspan(std::size_t(setup.parameters.transfer_first), 8));
}

Tables::Tables(const std::vector<glm::vec4>& entries) {
  GLint limit = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
  if (entries.size() > std::size_t(limit))
    throw Error(ExitCode::graphics,
                "the transfer function's tables have " + std::to_string(entries.size()) +
                    " entries, and the device's textures hold " + std::to_string(limit));
  glCreateBuffers(1, &buffer_);
  glNamedBufferStorage(buffer_, GLsizeiptr(entries.size() * sizeof(glm::vec4)), entries.data(), 0);
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &texture_);
  glTextureBuffer(texture_, GL_RGBA32F, buffer_);
}

Tables::~Tables() {
  glDeleteTextures(1, &texture_);
  glDeleteBuffers(1, &buffer_);
}

namespace {

std::string function_of(const ProgramKey& key) { return info(key.constants.integrator).name; }

/// The shader's one integrator: the march calls it by what it takes.
std::map<std::string, std::string> generated_files(const ProgramKey& key) {
  const std::string function = function_of(key);
  const std::string folder =
      is_transfer_rule(key.constants.integrator) ? "integrators/transfer/" : "integrators/";
  const auto call = [&](IntegratorKind kind, const std::string& signature,
                        const std::string& arguments, const std::string& none) {
    const bool own = info(key.constants.integrator).kind == kind;
    return signature + " { return " + (own ? function + arguments : none) + "; }\n";
  };
  const std::string weights = "Weights(0.0, 0.0, 0.0, 0.0)";
  return {
      {"integrator.glsl",
       "#include \"" + folder + function + ".glsl\"\n" +
           call(IntegratorKind::segment, "Weights integrate_segment(Segment s)", "(s)", weights) +
           call(IntegratorKind::cell, "float integrate_cell(Cubic c, float through, float s)",
                "(c, through, s)", "0.0") +
           call(IntegratorKind::transfer,
                "Mixture integrate_transfer(float front, float back, float length)",
                "(front, back, length)", "Mixture(0.0, vec3(0.0))")}};
}

}  // namespace

std::string common_prelude(const ProgramForm& form) {
  std::ostringstream text;
#define PSIVOX_ROW(name, value) \
  text << "const int " #name " = " << static_cast<int>(value) << ";\n";
  PSIVOX_SHADER_CONSTANTS(PSIVOX_ROW)
#undef PSIVOX_ROW
  text << "#define HOLDS_UNIFORMS " << int(form.holds_uniforms) << "\n";
  text << "#define COMPUTE " << int(form.computes) << "\n";
  return text.str();
}

int turns_per_pass(const MarchSetup& setup) {
  if (test_limits.turns_per_pass) return test_limits.turns_per_pass;
  // of 65535; a seventeenth is for the loop around every 16 turns (march.glsl)
  constexpr int driver_limit = 65535 / 17 * 16;
  const MarchConstants& c = setup.constants;
  const int pieces = c.uniform_sampling ? 1 : c.segments;
  // points of a turn, each of which may descend into two other grids' tables and search the
  // function
  const int points = 2 * pieces + 2;
  int emission_levels = 0;
#define GRID(id, name) \
  if (id >= emission_grid) emission_levels += c.name##_levels;
#include "grids.glsl"
#undef GRID
  const int levels = c.density_levels + c.other_volumes * (1 + c.others_levels) +
                     points * (c.luminance_levels + emission_levels) + points * c.gradient_levels;
  const int searches = c.transfer ? (points + 8) * setup.search_steps : 0;
  constexpr int bisections = 2 * 20;
  const int terms = emission_levels > 0 ? 10 * pieces : 0;
  const int roots = c.split_knots || c.shows == int(Shows::surface) ? bisections : 0;
  // the march ends passes after whole rounds of 16
  return driver_limit / (1 + pieces + levels + searches + roots + terms) - 16;
}

std::string ProgramKey::prelude() const {
  std::ostringstream text;
  text << std::boolalpha << "// " << function_of(*this) << "\n";
#define CONSTANT(type, name) text << "const " #type " " #name " = " << constants.name << ";\n";
#include "march_constants.glsl"
#undef CONSTANT
#define GRID(id, name) \
  text << "const int " #name "_buffers = " << std::max(buffers[id], 1) << ";\n";
#include "grids.glsl"
#undef GRID
  text << "const bool luminance_apart = " << (buffers[luminance_grid] > 0) << ";\n";
  // Only grids of several buffers read it: else one program serves atlases of any size.
  const bool several = *std::max_element(buffers.begin(), buffers.end()) > 1;
  text << "const int texels_per_buffer = " << (several ? texels_per_buffer : brick_texels) << ";\n";
  text << "#define RESUMABLE " << int(resumable) << "\n";
  return text.str();
}

ProgramKey program_key(MarchSetup& setup, const PerGrid<int>& buffers, int texels_per_buffer) {
  ProgramKey key;
  key.constants = setup.constants;
  key.buffers = buffers;
  key.texels_per_buffer = texels_per_buffer;
  int& turns = setup.parameters.max_turns;
  key.resumable = turns > turns_per_pass(setup);
  turns = std::min(turns, turns_per_pass(setup));
  return key;
}

ShaderSource march_source(const ProgramKey& key, const std::string& shader,
                          const ProgramForm& form) {
  return reduced(load_shader(shader, key.prelude() + common_prelude(form), generated_files(key)));
}

}  // namespace psivox::gl
