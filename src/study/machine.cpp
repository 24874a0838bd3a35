#include "study/results.h"

#include <sys/utsname.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "base/text.h"
#include "git_hash.h"
#include "psivox/error.h"
#include "psivox/leaf_values.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

/// The processor's name; "unknown" if the machine does not say.
std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string system_name() {
  utsname name{};
  if (uname(&name) != 0) return "unknown";
  return std::string(name.sysname) + " " + name.release + " " + name.machine;
}

/// FNV-1a, 64 bits in hexadecimal.
class Hash {
 public:
  void add(const char* bytes, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      value_ = (value_ ^ static_cast<unsigned char>(bytes[i])) * 0x100000001b3u;
  }
  std::string text() const { return formatted("%016llx", static_cast<unsigned long long>(value_)); }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

std::string file_hash(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  Hash hash;
  std::vector<char> block(1 << 20);
  while (file.read(block.data(), std::streamsize(block.size())) || file.gcount() > 0)
    hash.add(block.data(), std::size_t(file.gcount()));
  if (!file.eof()) throw Error(ExitCode::input, "cannot read " + in_quotes(path.string()));
  return hash.text();
}

std::string values_hash(const Field& field) {
  Hash hash;
  for (const Leaf& leaf : field.leaves) {
    const OrderedValues values(field, leaf);
    hash.add(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  }
  return hash.text();
}

}  // namespace

StudyResults new_results(const View& view, const std::string& renderer, int repeats) {
  const std::string& file = view.scene.input;
  StudyResults results;
  results.version = PSIVOX_VERSION;
  results.git = PSIVOX_GIT_HASH;
  results.processor = processor_name();
  results.system = system_name();
  results.threads = int(std::thread::hardware_concurrency());
  results.renderer = renderer;
  results.input = file.empty() ? "grids in memory" : file;
  results.input_hash = file.empty() ? values_hash(*view.medium.density) : file_hash(file);
  results.scene = to_json(view.scene);
  results.repeats = repeats;
  return results;
}

}  // namespace psivox
