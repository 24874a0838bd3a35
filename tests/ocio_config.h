#pragma once

#include <string>

#include "base/text_file.h"

namespace psivox {

/// Writes a small OpenColorIO config. Its views of display `Screen`: `Plain` is sRGB's curve;
/// `Warm` mixes the colours and has a power of 2.2.
inline void write_ocio_config(const std::string& path) {
  write_text(path, R"(ocio_profile_version: 2
roles: {default: raw, scene_linear: light}
file_rules:
  - !<Rule> {name: Default, colorspace: default}
displays:
  Screen:
    - !<View> {name: Plain, colorspace: srgb}
    - !<View> {name: Warm, colorspace: warm}
colorspaces:
  - !<ColorSpace>
    name: raw
    isdata: true
  - !<ColorSpace>
    name: light
  - !<ColorSpace>
    name: srgb
    from_scene_reference: !<ExponentWithLinearTransform> {gamma: [2.4, 2.4, 2.4, 1], offset: [0.055, 0.055, 0.055, 0], direction: inverse}
  - !<ColorSpace>
    name: warm
    from_scene_reference: !<GroupTransform>
      children:
        - !<MatrixTransform> {matrix: [0.8, 0.2, 0, 0, 0.1, 0.8, 0.1, 0, 0, 0.2, 0.6, 0, 0, 0, 0, 1]}
        - !<ExponentTransform> {value: [2.2, 2.2, 2.2, 1], direction: inverse}
)");
}

}  // namespace psivox
