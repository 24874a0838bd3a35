#pragma once

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>

namespace psivox {

/// The option that does what an option of that name does in vdb_render, F3D, ParaView, Blender or
/// elsewhere; empty if none is known. It comes before suggestion(): `--samples` resembles
/// `--sampling`.
inline std::string option_of_concept(std::string_view name) {
  struct Concept {
    std::string_view name, option;
  };
  static constexpr Concept concepts[] = {
      {"--absorb", "--extinction"},
      {"--alpha", "--opacity"},
      {"--backdrop", "--background"},
      {"--bg", "--background"},
      {"--brightness", "--exposure"},
      {"--color", "--colormap"},
      {"--contour", "--isovalue"},
      {"--crop", "--clip"},
      {"--cut", "--clip"},
      {"--density", "--extinction"},
      {"--dimensions", "--resolution"},
      {"--eye", "--camera-position"},
      {"--field", "--grid"},
      {"--from", "--camera-position"},
      {"--gain", "--exposure"},
      {"--gamma", "--exposure"},
      {"--gpu", "--device"},
      {"--height", "--resolution"},
      {"--layers", "--aov"},
      {"--legend", "--color-bar"},
      {"--level", "--range"},
      {"--levels", "--range"},
      {"--lookat", "--camera-target"},
      {"--lut", "--colormap"},
      {"--output-file", "--output"},
      {"--palette", "--colormap"},
      {"--passes", "--aov"},
      {"--plane", "--mode"},
      {"--plot", "--mode"},
      {"--preset", "--look"},
      {"--rays", "--pixel-samples"},
      {"--samples", "--pixel-samples"},
      {"--scalar-bar", "--color-bar"},
      {"--scalars", "--grid"},
      {"--scattering", "--albedo"},
      {"--shadow", "--light"},
      {"--size", "--resolution"},
      {"--slice-axis", "--slice"},
      {"--slice-position", "--slice"},
      {"--spp", "--pixel-samples"},
      {"--style", "--look"},
      {"--sun", "--light"},
      {"--threshold", "--isovalue"},
      {"--tonemap", "--tone-map"},
      {"--translate", "--camera-position"},
      {"--variable", "--grid"},
      {"--volume-range", "--range"},
      {"--width", "--resolution"},
      {"--window", "--range"},
  };
  const auto same = [&](const Concept& c) { return c.name == name; };
  const auto found = std::find_if(std::begin(concepts), std::end(concepts), same);
  return found == std::end(concepts) ? "" : std::string(found->option);
}

}  // namespace psivox
