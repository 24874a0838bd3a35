#include "overwriting.h"

#include <filesystem>

#include "psivox/error.h"
#include "psivox/text.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

bool is_file(const std::string& path) { return !path.empty() && path != "-"; }

/// Devices such as /dev/null keep nothing that could be lost.
bool same_file(const std::string& a, const std::string& b) {
  if (!is_file(a) || !is_file(b)) return false;
  std::error_code missing;
  if (fs::exists(a, missing) && fs::exists(b, missing))
    return fs::is_regular_file(a, missing) && fs::equivalent(a, b, missing);
  return fs::weakly_canonical(a, missing) == fs::weakly_canonical(b, missing);
}

}  // namespace

void check_overwriting(std::span<const WrittenFile> written, std::span<const std::string> read) {
  for (std::size_t n = 0; n < written.size(); ++n) {
    const auto& [option, path] = written[n];
    const std::string what = std::string(option) + " " + in_quotes(path);
    for (const std::string& input : read)
      if (same_file(path, input))
        throw Error(ExitCode::usage, what + " is the input " + in_quotes(input) +
                                         ", which it would replace; give another name");
    for (const WrittenFile& other : written.first(n))
      if (same_file(path, other.path))
        throw Error(ExitCode::usage, what + " is also the file of " + std::string(other.option) +
                                         "; give another name");
  }
}

}  // namespace psivox
