#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "psivox/look.h"
#include "psivox/medium.h"
#include "psivox/parameters.h"

namespace psivox {

/// The scene with settings over the camera of a file (`FILE[:NAME]`; empty: none) over what it has.
/// `z_is_up`: whether Z is up in a scene that may leave it open. Throws Error(usage), Error(input).
Scene with_settings(Scene scene, const std::string& camera, std::span<const Setting> settings,
                    const std::function<bool(const Scene&)>& z_is_up);

/// Throws Error(usage) if the scene's picture cannot have one of the layers (as --aov names them),
/// or cannot be drawn in a time budget.
void check_picture(const Scene& scene, const std::vector<std::string>& layers, bool time_budget);

/// How open_scene chooses and reads.
struct OpenOptions {
  std::string open_look = "auto";  ///< look of a scene that leaves it open
  bool background = true;          ///< whether a look may set one
  Parts parts{};                   ///< where the density's values may be
};

/// A scene in its look, its file read, and nothing left open. Render, frames, the window, Python,
/// `info` and studies start from it; Session(opened.view) draws it.
struct OpenedScene {
  LookedScene looked;
  View view;
};

/// Chooses the scene's look, reads its grids and resolves the rest. Throws Error(input),
/// Error(usage), Error(memory).
OpenedScene open_scene(const Scene& scene, const VdbFile& file, const OpenOptions& options = {});

/// The same for fields at hand, with no look to choose.
OpenedScene open_scene(const Scene& scene, MediumFields fields);

/// What reading changed in a medium's grids, each line once.
std::vector<std::string> notices_of(const Medium& medium);

}  // namespace psivox
