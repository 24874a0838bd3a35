#pragma once

#include <map>
#include <string>
#include <vector>

namespace psivox::gl {

/// A shader's text with its includes expanded, and where each of its lines comes from. No #line is
/// used: Mesa 22.3 loses its source-string number in some errors, "undeclared" among them.
struct ShaderSource {
  struct Place {
    std::string file;
    int line = 0;
  };
  std::string text;
  std::vector<Place> places;  ///< of each line of text

  void add_line(const std::string& line, const Place& place);

  /// A driver's log with `0:217` or `0(217)` written as `ray.glsl:17`.
  std::string map_log(const std::string& log) const;
};

/// Expands `name` from the shader folder: the embedded one, or where PSIVOX_SHADER_DIR is set, that
/// folder's files. `prelude` follows the #version line; `generated` adds files that exist only for
/// this shader. Throws Error(graphics) naming the file and line of an include that is not found.
ShaderSource load_shader(const std::string& name, const std::string& prelude,
                         const std::map<std::string, std::string>& generated);

}  // namespace psivox::gl
