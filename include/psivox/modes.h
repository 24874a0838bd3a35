#pragma once

/// The table of modes, one row each: X(name, shows, from_back, in_parts, look, option, help)
/// shows: a value of Shows. Shaders, parts and the reference draw a mode by it.
/// from_back: rays are composited from the back, so that none ends early or has a depth layer.
/// in_parts: a volume in parts, or whose values stay in the file, can be drawn.
/// look: the look that suits the mode; "auto" goes by the file, and "" is none.
/// option: the option that this mode alone has, if any.
// clang-format off
#define PSIVOX_MODES(X)                                                                                \
  X(alpha,         light,   false, true,  "auto",    "",               "the integral of the light")             \
  X(back_to_front, light,   true,  false, "auto",    "",               "the same sum from behind, without early termination") \
  X(mip,           value,   false, true,  "mip",     "",               "the greatest value over the range")     \
  X(lmip,          value,   false, true,  "mip",     "lmip-threshold", "the first local maximum of at least `--lmip-threshold`, or the greatest value") \
  X(minip,         value,   false, true,  "mip",     "",               "the least value over the range")        \
  X(mean,          value,   false, true,  "mip",     "",               "the mean value over the range")         \
  X(isosurface,    surface, false, true,  "surface", "isovalue",       "the surfaces of `--isovalue`, shaded") \
  X(xray,          depth,   false, true,  "xray",    "",               "the optical depth times `--luminance`") \
  X(slice,         plane,   false, true,  "",        "slice",          "the values on the plane `--slice`")
/// What a picture shows of its rays: composited light, the optical depth, a value, or a surface, by the
/// file of that name in shaders/modes/; or the values on a plane, without a march. X(name)
#define PSIVOX_SHOWS(X) X(light) X(depth) X(value) X(surface) X(plane)
// clang-format on

namespace psivox {

enum class Mode {
#define PSIVOX_ROW(name, ...) name,
  PSIVOX_MODES(PSIVOX_ROW)
#undef PSIVOX_ROW
};

enum class Shows {
#define PSIVOX_ROW(name) name,
  PSIVOX_SHOWS(PSIVOX_ROW)
#undef PSIVOX_ROW
};

/// A row of the table. `name` has underscores; the command line's has dashes.
struct ModeInfo {
  Mode id;
  const char* name;
  Shows shows;
  bool from_back;
  bool in_parts;
  const char* look;
  const char* option;
  const char* help;
};

inline constexpr ModeInfo mode_rows[] = {
#define PSIVOX_ROW(name, shows, from_back, in_parts, look, option, help) \
  {Mode::name, #name, Shows::shows, from_back, in_parts, look, option, help},
    PSIVOX_MODES(PSIVOX_ROW)
#undef PSIVOX_ROW
};

constexpr const ModeInfo& info(Mode id) { return mode_rows[int(id)]; }

/// The mode that composites the same light from the front, and so has its depths.
constexpr Mode from_front(Mode id) { return info(id).from_back ? Mode::alpha : id; }

}  // namespace psivox
