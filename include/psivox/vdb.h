#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "psivox/error.h"
#include "psivox/field.h"

namespace psivox {

/// Active values of a grid; lengths, if it has vectors.
struct ValueStatistics {
  double least = 0, greatest = 0;
  double mean = 0;               ///< over voxels; a tile counts with all of its own
  std::uint64_t not_finite = 0;  ///< voxels with NaN or infinity, which are left out
  std::uint64_t filled = 0;      ///< voxels with a fill value, which are left out, too
  double fill = 0;               ///< that value, if there are any
};

/// Information about one grid of a file. `problem` is empty if the grid can be rendered.
struct GridInfo {
  std::string name;  ///< as --grid takes it: `density`, or `density[1]` where names repeat
  std::string type;  ///< OpenVDB's grid type, such as Tree_float_5_4_3; of a scan its format
  /// float, double, int32, int64, bool, mask, points, vec3s, vec3d, vec3i; of a scan int8, uint8,
  /// ..., float32, float64, or `vec3 of uint8`; empty if unsupported
  std::string value_type;
  std::string grid_class;  ///< `fog volume`, `level set`, `staggered`, `scan`, `unknown`
  int channels = 0;        ///< 1 scalar, 3 vector, 0 unsupported
  bool saved_as_half = false;
  std::uint64_t active_voxels = 0;
  std::uint64_t leaves = 0;
  std::uint64_t active_tiles = 0;
  Box active_box;
  glm::dvec3 voxel_size{0};               ///< lengths of the transform's columns [world units]
  glm::dmat4 world_from_index{1.0};       ///< valid for affine transforms
  std::string transform;                  ///< OpenVDB's map type: UniformScaleMap, AffineMap, ...
  double background = 0;                  ///< first component
  bool values_read = true;                ///< false: only the topology
  std::optional<ValueStatistics> values;  ///< unset if no active value is finite
  glm::dvec3 world_min{0}, world_max{0};  ///< of the active voxels' centres
  std::map<std::string, std::string> metadata;  ///< as text, without what the rows above tell
  std::string problem;                          ///< why this grid cannot be rendered, in one line
};

/// What a picture could be made of.
struct GridContent {
  std::uint64_t active_voxels = 0;  ///< 0 if the grid cannot be read
  /// Why there is nothing to draw, as the rest of a sentence: no voxel is active, all active values
  /// are 0, or the grid cannot be read. Empty: there is something.
  std::string nothing;
};

/// What a file's header tells of a grid's place.
struct GridPlace {
  std::uint64_t voxels = 0;               ///< active ones; meaningless unless `known`
  bool known = false;                     ///< voxels and, if there are any, the next two
  glm::dvec3 world_min{0}, world_max{0};  ///< of the active voxels' centres
  double voxel_size = 0;                  ///< of the finest axis; 0: not known
  glm::ivec3 domain{0};  ///< voxels of the domain, in a cache of Blender's; 0: not known
};

/// How a grid's values are used. NaN and +-Inf are always bad values; negative values are bad
/// unless they are mapped first.
enum class GridRole {
  attenuation,
  luminance,  ///< radiance, or a factor of it: negative light is no light
  data,       ///< input of a transfer function, a colour map or a black body: negative values stay
};

struct ReadOptions {
  GridRole role = GridRole::attenuation;
  bool strict = false;     ///< bad values and non-linear transforms are errors
  bool distances = false;  ///< a level set keeps its distances (Field::half_width), else it is fog
  bool absent = false;     ///< voxels without data are absent (Field::absent), else 0
  bool fill = true;        ///< fill values are looked for, and are no data
  std::optional<float> fill_value = {};  ///< this value is no data
  /// A grid without active voxels is a field of zeros, not an error, and so is one that the file
  /// lacks.
  bool empty = false;
  bool active = false;  ///< 1 at active voxels and tiles, in place of the values
  /// Taken in place of a background other than 0; unset: 0, and an error if `strict`.
  std::optional<double> background = {};
  std::vector<double> percentiles = {};  ///< of the active values, to be found [%]
  /// Most bytes of leaves' values to keep in memory. Those of a larger grid stay in the file
  /// (Field::reader), unless the grid must be converted whole; reading looks at each of them once,
  /// and does not look for fill values. 0: no limit.
  std::uint64_t memory = 0;
  bool in_file = false;  ///< they stay there, however few
  /// Of values that stay in the file: whether reading looks at them. If not, there are neither
  /// ranges nor percentiles, and no tiles.
  bool survey = true;
};

class VolumeFile;

/// `scan.nii.gz[12]` is one frame of a file, unless a file has that name. Elsewhere the whole path
/// is the file's.
struct FrameOfFile {
  std::filesystem::path file;
  std::string frame;  ///< `[12]`; empty: all that the file has
};
FrameOfFile frame_of_file(const std::string& path);
/// The file of a frame: as long as it is held, frames that are read in their order are unpacked
/// once. Null: the path is a whole file's. Throws Error(input).
std::shared_ptr<const VolumeFile> file_of_frame(const std::string& path);

/// A grid of a file, under the name that it has elsewhere.
struct NamedGrid {
  std::string name;
  std::shared_ptr<const VolumeFile> file;
  std::string grid;  ///< as the file has it
};

/// An open .vdb or .nvdb, a scan (NIfTI, NRRD) or a frame of it (see frame_of_file), or grids in
/// memory that are used like one. Grids are read on demand; a broken grid does not keep the others
/// from being read. Its const functions may be called from several threads.
class VolumeFile {
 public:
  /// `progress` now and then receives the fraction of a grid that has been read. To end the reading
  /// it may throw anything but a std::exception, which would count as the file's error. Throws
  /// Error(input) if the file is missing, has none of these formats, or ends in its header. A
  /// scan's grid is `image`, or `rgb` of colours; of several frames `image[0]`, `image[1]`, ... Its
  /// world has x to the right, y to the front and z up, in the file's unit.
  explicit VolumeFile(const std::filesystem::path& path, Progress progress = {});
  /// A grid in memory, such as make_dense_field's. Its voxels other than 0 are active.
  explicit VolumeFile(std::shared_ptr<const Field> grid);
  /// Grids of other files, as if one file had them. Throws Error(usage) if names repeat.
  explicit VolumeFile(std::vector<NamedGrid> grids);
  ~VolumeFile();

  /// Names in file order, as `read` takes them. Reads no voxel, except from files written to a
  /// pipe, which have no directory. Grids without a name are `[0]`, `[1]`, ..., as OpenVDB prints
  /// them; a repeated name is `density[0]`, `density[1]`, ... Grids that cannot be read are listed
  /// too: info() says why.
  const std::vector<std::string>& names() const;

  /// Channels of a grid by `read`'s names: 1 scalar, 3 vector; 0 if there is none or it cannot be
  /// read.
  int channels(const std::string& grid) const;

  /// GridInfo::value_type of a grid by `read`'s names; empty if there is none.
  std::string value_type(const std::string& grid) const;

  /// The class of a grid by `read`'s names: `fog volume`, `level set`, `scan`, `unknown`; empty if
  /// there is no such grid.
  std::string grid_class(const std::string& grid) const;

  /// The file's own metadata, as text, by name.
  const std::map<std::string, std::string>& metadata() const;

  /// What tells that Z is up, such as `written by Blender`: the file's metadata, or names and
  /// metadata of its grids. Empty if nothing does.
  const std::string& z_up() const;

  /// Throws Error(input) if the file ends before its grids do, as one that is still being copied
  /// does. A grid that such a file does not list may have been cut off.
  void check_whole() const;

  /// One row per grid. Reads the trees, so that counts and boxes are true. Without `values` it
  /// reads no voxel's value of a .vdb that has positions; those are most of its bytes. Never throws
  /// for a bad grid.
  std::vector<GridInfo> info(bool values = true) const;

  /// What a grid holds, by `read`'s names. The first call reads the grid's topology, and its values
  /// until one is not 0; the answer is kept. Throws Error(memory) alone.
  GridContent content(const std::string& grid) const;
  bool holds_something(const std::string& grid) const { return content(grid).nothing.empty(); }
  /// Whether it is known to hold nothing without another look into the file.
  bool known_to_be_empty(const std::string& grid) const;

  /// What the file's header tells, by `read`'s names. It may be wrong, but its numbers are finite.
  GridPlace place(const std::string& grid) const;

  /// The grid to use if `--grid` is unset: the only one (if it cannot be rendered, `read` says
  /// why), else the best that holds something. Known names come first, in any case and behind other
  /// words (density, fog, smoke, ..., then temperature and the like), then fog volumes, level sets,
  /// other scalars, points, vectors and masks, and last a solver's own grids such as shadow or
  /// pressure; of these the one with the most active voxels. Beside an empty density nothing is
  /// drawn of a solver's own grids, nor of unknown names in a file of Blender's: it is the density.
  /// Throws Error(input), which names all grids and why each is not drawn, if none holds something;
  /// `empty`: then it is the first in that order.
  std::string default_grid(bool empty = false) const;

  /// Reads one grid: int, bool and double become float; level sets become fog by OpenVDB's own
  /// conversion, unless the options ask for distances; frustum transforms are resampled; NaN, Inf
  /// and negative values are counted and replaced (0, or the largest finite value for +Inf).
  /// With ReadOptions::background, places of a background other than 0 have that value instead.
  /// Field::notices tells what was done. A repeated name without its number means the first grid of
  /// that name, with a notice; the empty name means the first grid without a name. Field::name is
  /// the numbered name. With ReadOptions::memory, the file must not change while the field lives.
  /// Throws Error(input): no such grid (lists them), unsupported type, no active voxel, background
  /// other than 0 without ReadOptions::background, corrupt data. Throws Error(memory) if a grid
  /// that must be converted whole takes more than twice ReadOptions::memory.
  Field read(const std::string& grid, const ReadOptions& options = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// OpenVDB's version, as its library reports it.
std::string openvdb_version();

/// From now on every VolumeFile that is opened is read in a process of its own: a damaged or
/// hostile file that makes OpenVDB crash, hang or ask for all memory is an Error(input), and a file
/// that takes the process over can neither open files nor start programs there.
///
/// To be called at the beginning of main(), before any thread starts: it forks a process that forks
/// the readers. That process ends with this one. Without this call, VolumeFile reads in place, and
/// such a file can end the program. Throws Error(failure) if the system starts no process.
void start_guarded_reading();

/// For a process that may have threads already, such as an interpreter: it starts `server`, a
/// program that calls serve_guarded_reading(), in place of a fork. Any thread may call it, at any
/// time. Throws Error(failure).
void start_guarded_reading(const std::filesystem::path& server);

/// The main() of that program.
[[noreturn]] void serve_guarded_reading();

/// How VolumeFiles are read that are opened from now on, as `--trust` has it.
enum class Trust {
  no,         ///< in a guarded process whose calls the kernel restricts, or not at all
  if_needed,  ///< in a guarded process, under the limits that this system has
  yes,        ///< in place
};
void trust_files(Trust trust = Trust::yes);

/// What guards reading here, as a process of that kind has found: `seccomp and resource limits`;
/// `resource limits, without seccomp` if the kernel refuses it; `nothing` if files are read in
/// place, or `nothing: ` and why this psivox always does so.
std::string reading_guard();

}  // namespace psivox
