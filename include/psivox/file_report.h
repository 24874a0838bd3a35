#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "psivox/parameters.h"
#include "psivox/scene.h"
#include "psivox/vdb.h"

namespace psivox {

/// Names of the parameters that depend on the file if they are left open.
const std::vector<std::string>& chosen_by_auto();

struct GridReport {
  GridInfo grid;
  std::optional<AtlasSize> atlas{};  ///< in float32; set if the grid can be rendered
  bool usable() const { return grid.problem.empty(); }
};

/// All that `psivox info` tells of a file.
struct FileReport {
  std::string path;
  std::uint64_t bytes = 0;
  std::map<std::string, std::string> metadata;
  std::string z_up;  ///< what tells that Z is up; empty: nothing
  std::vector<GridReport> grids;
  /// The scene of `psivox render FILE -o x.png` with what psivox chooses; unset if it cannot be
  /// drawn.
  std::optional<Scene> chosen;
  std::string look;          ///< that auto has chosen for it
  std::vector<Setting> set;  ///< by that look, beside what depends on the file anyway
  std::string dark_because;  ///< why a look with light was not chosen; else empty
  std::string advice;        ///< what to do if no picture can be drawn; else empty

  std::string json() const;
  std::string text() const;
};

/// Without `values`, neither values nor what follows from them is known: atlases and the choice of
/// `auto`. Throws Error(input) if the file cannot be read.
FileReport report_of(const std::string& path, bool values = true);

}  // namespace psivox
