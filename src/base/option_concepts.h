#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "base/text.h"

namespace psivox {

/// The option that does what an option of that name does in vdb_render, F3D, ParaView, Blender or
/// elsewhere; empty if none is known. It comes before suggestion(): `--samples` resembles
/// `--sampling`.
inline std::string option_of_concept(std::string_view name) {
  static constexpr std::pair<std::string_view, std::string_view> concepts[] = {
      {"--albedo", "scattering"},
      {"--aov", "layers passes"},
      {"--background", "backdrop bg"},
      {"--camera-position", "eye from translate"},
      {"--camera-target", "lookat"},
      {"--clip", "crop cut"},
      {"--color-bar", "legend scalar-bar"},
      {"--colormap", "color lut palette"},
      {"--device", "gpu"},
      {"--exposure", "brightness gain gamma"},
      {"--extinction", "absorb density"},
      {"--grid", "field scalars variable"},
      {"--isovalue", "contour threshold"},
      {"--light", "shadow sun"},
      {"--look", "preset style"},
      {"--mode", "plane plot"},
      {"--opacity", "alpha"},
      {"--output", "output-file"},
      {"--pixel-samples", "rays samples spp"},
      {"--range", "level levels volume-range window"},
      {"--resolution", "dimensions height size width"},
      {"--slice", "slice-axis slice-position"},
      {"--tone-map", "tonemap"},
  };
  if (!name.starts_with("--")) return "";
  for (const auto& [option, names] : concepts)
    if (std::ranges::count(split(names, ' '), name.substr(2)) > 0) return std::string(option);
  return "";
}

}  // namespace psivox
