#pragma once

#include <optional>
#include <string>
#include <vector>

#include "psivox/medium.h"
#include "psivox/parameters.h"

namespace psivox {

/// Names of the looks that psivox brings: `fire`, `plain`, ... `auto` is not among them.
std::vector<std::string> look_names();
/// Those, and the names of the files in PSIVOX_LOOKS that are not among them, ascending.
std::vector<std::string> available_looks();

/// Whether the scene sets nothing of how a picture looks: neither luminance, light, colours,
/// temperature, emission, background nor any mode but xray. `auto` then chooses a look. A range, an
/// opacity, an isovalue and a clip go with any look.
bool leaves_look_open(const Scene& scene);

/// The scene without anything of how a picture looks, and without its look. Its grids, camera, clip
/// and exposure stay.
Scene without_look(Scene scene);

/// A scene in its look.
struct LookedScene {
  /// Its look is `plain`, so that drawing it again gives the same picture.
  Scene scene;
  std::string look;                         ///< `smoke`
  std::vector<Setting> settings;            ///< what the look has set
  std::vector<std::string> unused_grids{};  ///< grids that the picture does not show
  MediumFields fields;                      ///< read for the scene
  std::string dark_because{};               ///< why psivox has chosen a look without light
};

/// Sets what the scene's look says and the scene itself leaves open. A look is a JSON file of scene
/// parameters: one of psivox's own, one of the folders in the environment's PSIVOX_LOOKS (separated
/// by colons), or a path. Its list `choose` names what comes from the file's values:
///   range       2 to 96 % of the values, or 50 to 99.5 % where most are low, so that vessels or
///               plumes stand out
///   extinction  a third of a light's intensity reaches the medium, on average over what it
///               attenuates, but no less than auto_extinction; 0.6 of it for scans whose values
///               are mostly low
///   brightness  light and luminance, so that the mean luminance of what is covered is 0.25, unless
///               3 % of it would then be brighter than white
///   flame       grid, temperatures and brightness of a fire (see flame.h)
/// The look `auto`, or no look where the scene leaves it open and `open` is `auto`, goes by the
/// mode and the grids: `xray` for that mode, `surface` for level sets, `fire` where there is a
/// density and a flame, `scan` for digitised values and those that do not fade to 0, else `smoke`.
/// Vectors stay `plain`, and so does a volume whose light takes too much memory (light_obstacle),
/// or whose values stay in the file, unless several processes share it: they choose what one
/// process would, to the last bit. `background`: whether the look may set one. Throws Error(input),
/// Error(usage), Error(memory).
LookedScene with_look(const Scene& scene, const VdbFile& file, const std::string& open = "plain",
                      bool background = true, const Parts& parts = {});

}  // namespace psivox
