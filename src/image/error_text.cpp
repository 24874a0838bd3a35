#include "error_text.h"

#include "psivox/text.h"

namespace psivox::image_io {

std::string one_line(const std::string& text) {
  std::string line;
  bool pending_break = false;
  for (const char c : text) {
    if (c == '\n' || c == '\r') {
      pending_break = !line.empty();
    } else {
      if (pending_break) line += "; ";
      pending_break = false;
      line += c;
    }
  }
  return line;
}

Error read_error(const std::filesystem::path& path, const std::string& why) {
  return Error(ExitCode::input, "cannot read " + in_quotes(path.string()) + ": " + one_line(why));
}

Error write_error(const std::filesystem::path& path, const std::string& why) {
  return Error(ExitCode::output, "cannot write " + in_quotes(path.string()) + ": " + one_line(why));
}

}  // namespace psivox::image_io
