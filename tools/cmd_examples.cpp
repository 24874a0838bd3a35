// psivox examples: draws the volume that comes with psivox in five looks.

#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "base/text.h"
#include "base/text_file.h"
#include "command_line.h"

namespace psivox {

void examples_command(Arguments arguments) {
  std::string folder = "psivox-examples";
  bool quiet = false;
  CommandLine line("examples",
                   "Draws the volume that comes with psivox in five looks, and prints the command "
                   "for each.",
                   {}, {"", "-o pictures", "-o pictures -q"});
  line.add_value("-o,--output", folder, "DIR", "folder of the pictures and the volume")
      ->capture_default_str();
  line.add_flag("-q,--quiet", quiet, "print errors only");
  if (!line.read(arguments)) return;
  const auto in_folder = [&](const std::string& name) {
    return (std::filesystem::path(folder) / name).string();
  };
  make_folder(folder);
  const std::string volume = in_folder("blobs.vdb");
  write_text(volume, example_files().at("blobs.vdb"));
  for (const std::string look : {"smoke", "fire", "surface", "scan", "xray"}) {
    std::vector<std::string> call{volume, "-o", in_folder(look + ".png"), "--look", look};
    if (quiet)
      call.emplace_back("-q");
    else
      std::cout << "psivox render " << shell_word(volume) << " -o " << shell_word(call[2])
                << " --look " << look << std::endl;
    render_command(call);
  }
}

}  // namespace psivox
