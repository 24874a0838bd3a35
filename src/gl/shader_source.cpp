#include "gl/shader_source.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <utility>

#include "psivox/error.h"

namespace psivox::gl {
namespace {

std::string read_shader(const std::string& name, const std::string& included_from) {
  const std::string from = included_from.empty() ? "" : " (included from " + included_from + ")";
  if (const char* folder = std::getenv("PSIVOX_SHADER_DIR")) {
    const auto path = std::filesystem::path(folder) / name;
    std::ifstream in(path, std::ios::binary);
    if (!in)
      throw Error(ExitCode::graphics, "shader '" + path.string() + "' cannot be read" + from +
                                          "; PSIVOX_SHADER_DIR must hold a copy of shaders/");
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }
  const auto found = embedded_shaders().find(name);
  if (found == embedded_shaders().end())
    throw Error(ExitCode::graphics, "shader '" + name + "' does not exist" + from);
  return found->second;
}

void expand(const std::string& name, const std::string& included_from,
            const std::map<std::string, std::string>& generated, ShaderSource& source) {
  const auto own = generated.find(name);
  const std::string text = own != generated.end() ? own->second : read_shader(name, included_from);
  const auto folder = std::filesystem::path(name).parent_path();

  std::string_view lines = text;
  for (int i = 1; !lines.empty(); ++i) {
    const std::string_view line = take_line(lines);
    if (line.starts_with("#include \"")) {
      const std::string_view included = line.substr(10, line.rfind('"') - 10);
      const std::string here = name + ":" + std::to_string(i);
      expand((folder / included).lexically_normal().string(), here, generated, source);
    } else {
      source.add_line(line, {name, i});
    }
  }
}

}  // namespace

std::string_view take_line(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(line.size() + 1, text.size()));
  return line;
}

void ShaderSource::add_line(std::string_view line, Place place) {
  text += line;
  text += '\n';
  places.push_back(std::move(place));
}

ShaderSource load_shader(const std::string& name, const std::string& prelude,
                         const std::map<std::string, std::string>& generated) {
  ShaderSource source;
  source.add_line("#version 450 core", {"version", 1});
  std::string_view lines = prelude;
  for (int i = 1; !lines.empty(); ++i) source.add_line(take_line(lines), {"prelude", i});
  expand(name, "", generated, source);
  return source;
}

std::string ShaderSource::map_log(const std::string& log) const {
  // Mesa writes 0:217(5): error, NVIDIA 0(217) : error
  static const std::regex number(R"((^|\n)(ERROR: )?\d+[:(](\d+)(\) )?(\(\d+\))?)");
  std::string result;
  auto begin = log.cbegin();
  for (std::smatch m; std::regex_search(begin, log.cend(), m, number); begin = m.suffix().first) {
    const std::size_t line = std::stoul(m[3]);
    result += m.prefix().str() + m[1].str();
    if (line >= 1 && line <= places.size())
      result += places[line - 1].file + ":" + std::to_string(places[line - 1].line);
    else
      result += m[0].str().substr(m[1].length());
  }
  return result + std::string(begin, log.cend());
}

}  // namespace psivox::gl
