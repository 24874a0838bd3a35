// psivox info IN.vdb: tells what the file contains, and what psivox would make of it.

#include <iostream>
#include <optional>
#include <string>

#include "command_line.h"
#include "commands.h"
#include "psivox/file_report.h"
#include "region_report.h"

namespace psivox {

void info_command(Arguments arguments) {
  std::string path;
  bool as_json = false, topology = false;
  std::optional<int> regions;
  CommandLine line("info",
                   "Tells what a .vdb contains: grids, values, boxes, and what auto chooses.", {},
                   {"smoke.vdb", "smoke.vdb --json", "smoke.vdb --regions 4"});
  line.add_option("IN.vdb", path, "file to describe")->type_name("")->required();
  line.add_flag("--topology", topology,
                "read no values of voxels: no ranges, sizes of atlases, nor what auto chooses");
  line.add_flag("--json", as_json, "print JSON");
  line.add_option("--regions", regions,
                  "print instead how K processes of MPI would split the volume: bricks, leaves and "
                  "memory of each")
      ->type_name("K")
      ->check(number_in<int>({.min = 1, .max = 100000}));
  line.add_trust();
  if (!line.read(arguments)) return;
  if (regions) {
    const RegionReport split = regions_of(path, *regions);
    std::cout << (as_json ? split.json() : split.text());
    return;
  }
  const FileReport report = report_of(path, !topology);
  std::cout << (as_json ? report.json() : report.text());
}

}  // namespace psivox
