#pragma once

namespace psivox::view {

/// A row of the keyboard help, in the window and in docs/preview.md.
struct KeyHelp {
  const char* keys;
  const char* what;
};

inline constexpr KeyHelp key_help[] = {
    {"left drag", "orbit around the pivot"},
    {"middle drag", "pan"},
    {"wheel, right drag", "dolly towards the pivot"},
    {"double click", "pivot on what is under the pointer"},
    {"W A S D, E Q", "fly forward, left, back, right, up, down"},
    {"F", "frame all"},
    {"1 3 7", "view from the front, the right, above; with Shift or Ctrl from the other side"},
    {"O", "orthographic or perspective"},
    {"T", "transfer function"},
    {"X", "one picture, two with a divider, signed difference"},
    {"Space", "play or pause a sequence"},
    {"Left, Right", "frame before, frame after"},
    {"R", "read file and shaders again"},
    {"Ctrl+S", "save the picture"},
    {"Ctrl+C", "copy as command line"},
    {"Tab", "panel"},
    {"? or H", "this help"},
};

}  // namespace psivox::view
