// psivox info IN.vdb: tells what the file contains, and what psivox would make of it.

#include <iostream>
#include <string>

#include "command_line.h"
#include "commands.h"
#include "psivox/file_report.h"

namespace psivox {

void info_command(Arguments arguments) {
  std::string path;
  bool as_json = false, topology = false;
  CommandLine line("info",
                   "Tells what a .vdb contains: grids, values, boxes, and what auto chooses.");
  line.add_option("IN.vdb", path, "file to describe")->type_name("")->required();
  line.add_flag("--topology", topology,
                "read no values of voxels: no ranges, sizes of atlases, nor what auto chooses");
  line.add_flag("--json", as_json, "print JSON");
  line.add_trust();
  if (!line.read(arguments)) return;
  const FileReport report = report_of(path, !topology);
  std::cout << (as_json ? report.json() : report.text());
}

}  // namespace psivox
