#include "gl/march_program.h"

#include <sstream>

namespace psivox::gl {
namespace {

std::string function_of(const MarchVariant& variant) {
  return info(variant.constants.integrator).name;
}

/// The shader's one integrator: march.glsl calls it by what it takes, a segment or a cell.
std::map<std::string, std::string> generated_files(const MarchVariant& variant) {
  const std::string function = function_of(variant);
  const std::string none = "{ return Weights(0.0, 0.0, 0.0, 0.0); }\n";
  const bool cell = variant.constants.cell_rule;
  return {{"integrator.glsl", "#include \"integrators/" + function + ".glsl\"\n" +
                                  "Weights integrate_segment(Segment s) " +
                                  (cell ? none : "{ return " + function + "(s); }\n") +
                                  "Weights integrate_cell(Cubic c, float x) " +
                                  (cell ? "{ return " + function + "(c, x); }\n" : none)}};
}

}  // namespace

std::string MarchVariant::prelude() const {
  std::ostringstream text;
  text << std::boolalpha << "// " << function_of(*this) << "\n";
#define CONSTANT(type, name) text << "const " #type " " #name " = " << constants.name << ";\n";
#include "march_constants.glsl"
#undef CONSTANT
  text << "#define DENSITY_BUFFERS " << density_buffers << "\n#define LUMINANCE_BUFFERS "
       << luminance_buffers << "\n#define TEXELS_PER_BUFFER " << texels_per_buffer
       << "\n#define RESUMABLE " << int(resumable) << "\n";
  return text.str();
}

MarchProgram::MarchProgram(const MarchVariant& variant)
    : variant_(variant), program_("march.frag", variant.prelude(), generated_files(variant)) {
  const auto bind = [&](const std::string& grid, int unit, int buffers) {
    program_.set((grid + "_pages").c_str(), unit);
    program_.set((grid + "_constants").c_str(), unit + 1);
    program_.set((grid + "_bricks").c_str(), unit + 2);
    for (int i = 0; i < buffers; ++i)
      program_.set((grid + "_texels[" + std::to_string(i) + "]").c_str(), unit + 3 + i);
  };
  bind("density", density_unit, variant.density_buffers);
  bind("luminance", luminance_unit(), variant.luminance_buffers);
}

void MarchProgram::configure(const MarchParameters& parameters) const {
#define PARAMETER(type, name) program_.set(#name, parameters.name);
#include "march_parameters.glsl"
#undef PARAMETER
}

}  // namespace psivox::gl
