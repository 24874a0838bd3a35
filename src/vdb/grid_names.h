#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "psivox/vdb.h"

// What the names of grids mean, in any case and in the forms that programs give them.

namespace psivox {

/// Words for what attenuates, the best first.
inline constexpr std::array density_words{"density", "fog",  "smoke", "cloud",
                                          "soot",    "dens", "rho"};

/// Words for colours that a smoke scatters.
inline constexpr std::array color_words{"cd", "albedo", "color", "colour", "diffuse"};

/// The words of a grid's name in lower case, without numbers at its end: `voxel_fogDensity` has
/// voxel, fog and density, `density_2` and `density[2]` have density.
std::vector<std::string> name_words(std::string_view grid);

/// How a grid's name says a word, or its plural with s.
enum class Saying { not_at_all, at_its_end, whole };
Saying saying(std::string_view grid, std::string_view word);

/// Whether the name says any of density_words.
bool says_density(std::string_view grid);

/// Whether the name is that of a solver's own grid, which shows nothing: a shadow, texture
/// coordinates, a pressure, distances of `phi`.
bool is_of_solver(std::string_view grid);

/// The grid of a file whose name says the word, whole before at its end, and which has so many
/// channels; empty if there is none.
std::string grid_saying(const VolumeFile& file, std::string_view word, int channels);

}  // namespace psivox
