// replay CORPUS: runs each file of CORPUS/TARGET/ through that target, crashers of the past among
// them. A finding ends the process.

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "psivox/vdb.h"
#include "targets.h"

int main(int count, char** arguments) {
  if (count != 2) return 2;
  psivox::start_guarded_reading();  // volumes may crash OpenVDB
  int files = 0;
  for (const psivox::fuzz::Target& target : psivox::fuzz::targets()) {
    const auto folder = std::filesystem::path(arguments[1]) / target.name;
    if (!std::filesystem::is_directory(folder)) {
      std::printf("no corpus for target '%s'\n", std::string(target.name).c_str());
      return 1;
    }
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      std::printf("%s\n", entry.path().c_str());
      std::fflush(stdout);  // the last line names the file that crashes
      std::ifstream file(entry.path(), std::ios::binary);
      const std::string bytes{std::istreambuf_iterator<char>(file), {}};
      psivox::fuzz::run(target.name, bytes);
      ++files;
    }
  }
  std::printf("%d files\n", files);
}
