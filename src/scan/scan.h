#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "base/file_blocks.h"
#include "psivox/error.h"
#include "psivox/field.h"

namespace psivox::scan {

enum class Type { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

/// Its name in `info`, such as `uint8`.
std::string_view name_of(Type type);
/// Its size [bytes].
int size_of(Type type);

enum class Encoding { raw, gzip, text, hex };

/// What the header of a NIfTI or NRRD file says of its values. Value (x, y, z) of channel c in
/// frame f is the file's value number x*strides[0] + y*strides[1] + z*strides[2] +
/// c*channel_stride + f*frame_stride; z has the greatest stride of the three.
struct Header {
  std::string format;  ///< `NIfTI-1`
  glm::ivec3 shape{1};
  std::array<std::int64_t, 3> strides{};
  int channels = 1;  ///< 1 or 3
  std::int64_t channel_stride = 0;
  std::int64_t frames = 1, frame_stride = 0;
  bool in_time = true;      ///< frames follow each other; else they are components, as of a tensor
  std::int64_t values = 0;  ///< all of the file

  Type type{};
  bool big_endian = false;
  Encoding encoding = Encoding::raw;
  bool detached = false;   ///< the values lie in a file beside the header
  std::int64_t begin = 0;  ///< of what is encoded, in its file [bytes]
  std::int64_t lines = 0;  ///< to pass over from there, as they lie in the file
  std::int64_t skip = 0;   ///< to pass over then, unpacked; -1: the values are the last [bytes]

  glm::dmat4 world_from_index{1.0};
  double slope = 1, intercept = 0;  ///< a value is slope * stored + intercept
  bool colour = false;              ///< the channels are red, green and blue
  bool statistic = false;           ///< values are those of a statistical test, not of a scanner
  std::string z_up;                 ///< what tells that Z is up; empty: nothing does
  std::map<std::string, std::string> metadata;
  std::vector<std::string> notices;  ///< one line each: what of the file is left out

  std::string value_type() const {
    return (channels > 1 ? "vec3 of " : "") + std::string(name_of(type));
  }
};

/// The path of the values that a header says lie beside it, in its folder or below; empty: they lie
/// in the header's own file. It uses nothing else of the header. Throws Error(input) if the header
/// names several files, or one elsewhere.
std::string data_path(FileBlocks& header);

class ValueStream;

/// An open NIfTI or NRRD file. Its functions may be called from several threads.
class Scan {
 public:
  /// `data`: the file at data_path(), or null if there is none. Throws Error(input) if the header
  /// claims more values than the file can hold, more than 65,536 frames, or voxels without a
  /// volume.
  Scan(Header header, std::shared_ptr<FileBlocks> file, std::shared_ptr<FileBlocks> data);
  ~Scan();

  const Header& header() const { return header_; }

  /// One frame, under that name. Voxels other than 0 are active. Values are rounded to float.
  /// Frames in their order are read fastest: a gzip is then unpacked once. Throws Error(input),
  /// Error(memory).
  Field read(std::int64_t frame, const std::string& name, const Progress& progress) const;

 private:
  /// Opens a stream anew if it is beyond the value.
  void start_at(std::size_t stream, std::int64_t value) const;

  Header header_;
  std::shared_ptr<FileBlocks> file_;                           ///< of the values
  mutable std::mutex mutex_;                                   ///< of what follows
  mutable std::vector<std::unique_ptr<ValueStream>> streams_;  ///< see Scan::read
};

/// The file's scan; null if it is of another format. Throws Error(input).
std::unique_ptr<Scan> open_scan(std::shared_ptr<FileBlocks> file, std::shared_ptr<FileBlocks> data);

}  // namespace psivox::scan
