#pragma once

#include <map>
#include <string>
#include <vector>

namespace psivox::gl {

/// A shader's text with its includes expanded, and which file each #line number stands for.
struct ShaderSource {
  std::string text;
  std::vector<std::string> files;  ///< by source-string number

  /// A driver's log with `2:17` or `2(17)` written as `ray.glsl:17`.
  std::string map_log(const std::string& log) const;
};

/// Expands `name` from the shader folder: the embedded one, or where PSIVOX_SHADER_DIR is set, that
/// folder's files. `prelude` follows the #version line; `generated` adds files that exist only for
/// this shader. Throws Error(graphics) naming the file and line of an include that is not found.
ShaderSource load_shader(const std::string& name, const std::string& prelude,
                         const std::map<std::string, std::string>& generated);

}  // namespace psivox::gl
