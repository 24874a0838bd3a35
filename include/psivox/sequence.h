#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "psivox/camera.h"
#include "psivox/open.h"
#include "psivox/vdb.h"

// Sequences: one file for each frame, and one scene for all of them.

namespace psivox {

/// The number of a frame: a count, or a time such as 20260131120000.
using FrameNumber = std::int64_t;

/// A path with a place for the number of a frame in its file name.
class FramePattern {
 public:
  /// The path's placeholder: `fire.####.vdb`, `fire.%04d.vdb` or `fire.$F4.vdb` pad the number with
  /// zeros to four digits; `#`, `%d` and `$F` do not pad. Unset if it has none. Throws Error(usage)
  /// for a second placeholder, and for one in a folder's name.
  static std::optional<FramePattern> of_placeholder(const std::string& path);
  /// The last number in a file's name, `fire.0012.vdb`, stands for any; unset if it has none.
  static std::optional<FramePattern> of_number(const std::string& path);

  std::string path(FrameNumber frame) const;
  /// `fire.####.vdb`, as of_placeholder reads it, with as many digits as a path that matches.
  std::string text(const std::string& path) const;
  /// The number in a path that matches the pattern.
  std::optional<FrameNumber> frame_of(const std::string& path) const;
  /// The same, but a number may have any digits.
  FramePattern in_any_padding() const;
  /// The files that match, by frame.
  std::map<FrameNumber, std::string> files() const;

  bool operator==(const FramePattern&) const = default;

 private:
  std::string before_, after_;  ///< of the path, around the number
  std::size_t digits_ = 0;      ///< to which numbers are padded; 0: numbers may have any padding
};

/// The frame that a file is: by the placeholder of the sequence's pattern, or, if that has none, by
/// the last number in the file's name.
std::optional<FrameNumber> frame_number(const std::string& pattern, const std::string& path);

inline constexpr int most_frames = 1000000;  ///< of a sequence

/// Numbers of frames from `1-100`, `1-100x2` (every second) or several of them, `1-10,20`;
/// ascending. Throws Error(usage), which begins with `option`.
std::vector<FrameNumber> read_frames(const std::string& text, const std::string& option);

/// Short text that read_frames reads: `1-10x3,20`. Ascending frames.
std::string frames_text(std::span<const FrameNumber> frames);

using SequenceFiles = std::map<FrameNumber, std::string>;

/// Whether psivox reads files of that name.
bool has_volume_name(const std::string& path);

/// The files of a sequence: those that match a pattern, the .vdb files of a folder, or the files
/// that are named. Names that differ in their last number only are its frames; other names are
/// numbered from 1 in their order. Unset if `inputs` is one path without a placeholder that is no
/// folder; `within`: nor a scan of several frames. Throws Error(input): no file; Error(usage): a
/// folder that holds several sequences.
std::optional<SequenceFiles> sequence_files(std::span<const std::string> inputs,
                                            bool within = false);

/// The frames between a sequence's first and last that have no file, where all distances of the
/// sequence's files are multiples of the least; none if they are not, or beyond a billion: such
/// numbers are times.
std::vector<FrameNumber> gaps(const SequenceFiles& files);

/// The files from which `auto` chooses unless others are named: the first, the middle, the last,
/// and the one of up to 64 in which most voxels burn, if any has a flame.
std::vector<std::string> auto_samples(const SequenceFiles& files);

/// The options of side grids that a look has set in `shown`, which `asked` leaves open: one frame
/// may have the grid and another not.
std::vector<std::string> chosen_grids(const Scene& asked, const Scene& shown);

/// Blender's domains that adapt: each frame's file has a domain of its own as wide as any other's,
/// of more or fewer voxels.
struct AdaptiveDomain {
  double voxel_size = 0;  ///< that all frames get
  glm::dvec3 floor{0};    ///< the middle of the lowest layer of all domains

  /// The scene with a file placed in it; unchanged if the file does not tell its domain.
  Scene placed(Scene scene, const GridPlace& place) const;
};

/// What `auto` chooses, once for all frames.
struct SequenceScene {
  /// Complete but for the input: no frame changes it.
  Scene scene;
  std::string look;                        ///< `smoke`
  std::vector<Setting> settings;           ///< what the look has set
  std::shared_ptr<const Subject> subject;  ///< what the frames show, all together
  /// Options of side grids that a frame may lack: those of chosen_grids(), and those that the scene
  /// names.
  std::vector<std::string> chosen_grids;
  std::string dark_because = {};  ///< why the look is plain; see LookedScene
  std::optional<AdaptiveDomain> adaptive = {};
  std::vector<std::string> notices = {};  ///< what of the frames is not known
};

/// What the headers of files tell that are no samples.
enum class Headers {
  unread,  ///< nothing
  placed,  ///< where a frame lies in Blender's domain that adapts
  seen     ///< and how far files reach, all of which the camera sees
};

/// Resolves a scene for a sequence by some of its files:
///   grid        `density` if one of them has it, else the grid of most
///   look        `fire` if one of them burns, else the look of most, else of the later ones
///   extinction  the least, so that the densest frame is as transparent as a picture of its own
///   range       from the least to the greatest value
///   brightness of light and flame: the least, so that the brightest frame is not clipped
///   camera      frames the subjects of all; and those of files that reach beyond them
///   isovalue and all else: those of the file with the least extinction
/// `files`: the sequence's, of which the nearest replaces a sample that is empty, and, if
/// `others_serve`, one that cannot be read.
/// Throws what make_view throws.
SequenceScene resolve_sequence(const Scene& scene, std::span<const std::string> samples,
                               const std::string& open_look = "plain", bool background = true,
                               std::span<const std::string> files = {}, bool others_serve = false,
                               Headers headers = Headers::seen);

/// The scene for one of the sequence's files, without grids of the look that the file lacks. A
/// further volume whose name has a placeholder is the file of that frame.
Scene frame_scene(const SequenceScene& sequence, const VolumeFile& file, const std::string& path);
/// Reads one of the sequence's files for its scene. `empty`: grids without active voxels count, as
/// zeros. Throws what open_scene throws.
OpenedScene open_frame(const SequenceScene& sequence, const VolumeFile& file,
                       const std::string& path, bool empty = true);

}  // namespace psivox
