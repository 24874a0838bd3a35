#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "psivox/medium.h"
#include "psivox/parameters.h"

namespace psivox {

/// Names of the looks that psivox brings: `fire`, `plain`, ... `auto` is not among them.
std::vector<std::string> look_names();
/// Those, and the names of the files in PSIVOX_LOOKS that are not among them, ascending.
std::vector<std::string> available_looks();

/// Whether `auto` chooses a look: the scene names none, its mode is alpha, back-to-front,
/// isosurface or xray, and nothing says how the medium shines (luminance, a grid of it,
/// temperatures, a transfer function). Each other option replaces its own part of the look that is
/// chosen.
bool leaves_look_open(const Scene& scene);

/// Whether smoke would hardly be seen before the scene's background, whose luminance is at least
/// 0.4.
bool has_bright_background(const Scene& scene);
/// By what a look then multiplies the smoke's albedo and luminance.
inline constexpr double dark_contrast = 0.3;

/// Whether a look may set a parameter, or make a choice of that name, beside what the scene gives.
bool leaves_to_look(const Scene& scene, std::string_view name);

/// The scene without anything of how a picture looks, and without its look. Its grids, camera,
/// clip, holdout and exposure stay.
Scene without_look(Scene scene);

/// A scene in its look.
struct LookedScene {
  /// Its look is `plain`, so that drawing it again gives the same picture.
  Scene scene;
  std::string look;                         ///< `smoke`
  std::vector<Setting> settings;            ///< what the look has set
  std::vector<std::string> unused_grids{};  ///< grids that the picture does not show
  MediumFields fields;                      ///< read for the scene
  std::string dark_because{};               ///< why psivox has not chosen a look with light
  bool guesses_up = false;                  ///< nothing tells which axis is up
  /// Value that fills the volume around the object, which the look makes transparent although it is
  /// not low.
  std::optional<double> outside{};
};

/// Sets what the scene's look says and the scene itself leaves open. A look is a JSON file of scene
/// parameters: one of psivox's own, one of the folders in the environment's PSIVOX_LOOKS (separated
/// by colons), or a path. Its list `choose` names what comes from the file's values:
///   range       2 to 96 % of the values, or 50 to 99.5 % where most are low and fill the volume:
///               vessels stand out
///   outside     what fills the volume around the object is transparent, a veil around it thin
///   padding     what fills the volume around the object is no data if it is far above all else,
///               and around labels if it is not 0
///   sides       distances have no surface beside their voxels
///   balance     a range with 0 in its middle that leaves out 0.5 % of the values at either end
///   colors      the active voxels of a grid of colours, as the density, in these colours
///   contrast    the smoke is dark before a bright background
///   extinction  a third of a light's intensity reaches the medium, on average over what it
///               attenuates, but no less than auto_extinction; 0.6 of it for scans whose values
///               are mostly low
///   flame       grid, temperatures and brightness of a fire
/// What the scene gives (is_given) stays. An option replaces its own parameter of the look.
/// `--light` and `--sky` replace all lights, `--emission-grid` the flame, and `--camera-position`
/// the angles. What says how the medium shines replaces all light, colour and emission.
///
/// The look `auto`, or no look where the scene leaves it open and `open` is `auto`, goes by the
/// mode and the grids: `xray` for that mode, `surface` for level sets and where an isovalue or the
/// mode asks for one, `vectors` and `colors` for grids of vectors, `points` for points, `signed`
/// for values on both sides of 0, `scan` with a colour map, `fire` where something glows beside
/// the density, `scan` for digitised values and those that do not fade to 0, else `smoke`. A volume
/// stays `plain` whose light takes too much memory (light_obstacle) or whose values stay in the
/// file. Several processes that share a volume choose by an overview of it (docs/performance.md).
/// What is chosen depends on the values alone, not on how a tree stores them. `background`: whether
/// the look may set one. Throws Error(input), Error(usage), Error(memory).
LookedScene with_look(const Scene& scene, const VolumeFile& file, const std::string& open = "plain",
                      bool background = true, const Parts& parts = {});

/// The scene with settings over the camera of a file (`FILE[:NAME]`; empty: none) over what it has.
/// `z_is_up`: whether Z is up in a scene that may leave it open. Throws Error(usage), Error(input).
Scene with_settings(Scene scene, const std::string& camera, std::span<const Setting> settings,
                    const std::function<bool(const Scene&)>& z_is_up);

/// Throws Error(usage) if the scene's picture cannot have one of the layers (as --aov names them).
void check_picture(const Scene& scene, const std::vector<std::string>& layers);

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
OpenedScene open_scene(const Scene& scene, const VolumeFile& file, const OpenOptions& options = {});

/// The same for fields at hand, with no look to choose.
OpenedScene open_scene(const Scene& scene, MediumFields fields);

/// What reading changed in a view's grids, and whether a shell encloses values below 0; each line
/// once.
std::vector<std::string> notices_of(const View& view);

}  // namespace psivox
