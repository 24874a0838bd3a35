#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "psivox/error.h"
#include "psivox/medium.h"

// A study renders one view by many methods and measures the error and the cost of each. The
// reference computes the light once, and all methods use it, so that their errors are their own.

namespace psivox {

/// The lists that a study varies; it renders all combinations.
struct Sweep {
  std::vector<Integrator> integrators;
  std::vector<Sampling> samplings;
  std::vector<int> segments;  ///< under cells
  std::vector<double> steps;  ///< under uniform [voxels of the finest axis]
  std::vector<Filter> filters;
  std::vector<TexelType> texels;
  std::vector<double> tolerances;       ///< RMS over R G B A; may be empty
  std::vector<glm::ivec2> resolutions;  ///< [pixels]; empty: the scene's

  Sweep();  ///< as sweep_lists() say
};

/// A list of a sweep, as the command line has it.
struct SweepList {
  std::string name, help;
  std::string usual;  ///< its items by default; empty: none
};
std::vector<SweepList> sweep_lists();

/// The scene's parameters that every sweep sets; a study's scene may not set them.
std::vector<std::string> swept_parameters();

/// What all pictures of a study have in common: the scene in exact light, with the defaults of all
/// parameters that a sweep sets.
Scene studied_scene(const Scene& scene);

/// Replaces one list by items separated by commas; a list of names also takes `all`. Throws
/// Error(usage).
void set_sweep(Sweep& sweep, std::string_view list, std::string_view text);

/// A picture that another renderer drew of the scene, through the study's camera.
struct ForeignPicture {
  std::string name;    ///< the renderer, and its setting after a space: "vdb_render step 1"
  std::string file;    ///< of any format that read_image knows
  double time_ms = 0;  ///< as its user gives it; 0: none
};

/// The picture that `NAME=FILE[,TIME_MS]` names. Throws Error(usage).
ForeignPicture foreign_picture(std::string_view text);

/// Reads a list in JSON, [{"name": , "picture": , "time_ms": }, ...]; files are named from its
/// folder. Throws Error(input), Error(usage).
std::vector<ForeignPicture> read_foreign_pictures(const std::string& path);

struct StudyOptions {
  std::filesystem::path folder;  ///< made if it is missing
  Sweep sweep;
  int repeats = 3;
  bool split = true;    ///< measure step and arithmetic error apart, by the march in double
  bool resume = false;  ///< go on with the study in the folder, if there is one
  std::vector<ForeignPicture> foreign{};  ///< compared too
  Progress progress{};
  std::function<bool()> stop{};  ///< called between and during renders; may be empty
  std::function<void(const std::string&)> say{};  ///< takes lines for the user; may be empty
};

/// Throws Error(usage) if the folder holds results or an index.html and `resume` is not set, and
/// Error(output) if the folder cannot be made or another study writes it. Leaves no folder that was
/// not there.
void check_study_folder(const std::filesystem::path& folder, bool resume);

/// Throws Error(usage) if a picture of another renderer has a name that is no name or another's, or
/// a time below 0; Error(input) if one cannot be read, has NaN or Inf, or another resolution than
/// the study of the scene.
void check_foreign(const StudyOptions& options, const Scene& scene);

/// Runs the study of a view from make_view and writes pictures, numbers and index.html to the
/// folder. It writes results.json and results.csv again after every point, so a study can be
/// stopped at any time. When `stop` returns true, it writes the report of the finished points and
/// throws Error(interrupted). Throws Error(usage) if the folder has other results or the sweep has
/// nothing to render, and what rendering throws. Returns the study's conclusion, which names the
/// settings to use.
std::string run_study(View view, const StudyOptions& options);

/// The finished study of a sequence's frame.
struct StudiedFrame {
  std::int64_t frame = 0;
  std::filesystem::path folder;
};

/// Compares the studies of a sequence's frames. Writes to `out`, for each method, the median, the
/// least and the greatest RMS, number of field look-ups and processor time over the frames:
/// frames.csv, frames.json and index.html. Returns a sentence: which method keeps 8 bits in every
/// frame. Throws Error(input).
std::string write_frame_statistics(const std::vector<StudiedFrame>& frames,
                                   const std::filesystem::path& out);

/// Draws scenes whose truth is known by many methods and compares errors and orders of convergence
/// with those expected. `full`: larger pictures, and Marschner and Lobb's signal as Weiss and
/// Westermann (2021) measure it. Writes suite.csv, suite.json and index.html. Returns a
/// sentence. Throws Error(verification) if an order or an error is not as it must be, when all is
/// written.
std::string run_suite(const std::filesystem::path& folder, bool full, int device,
                      const Progress& progress = {});

}  // namespace psivox
