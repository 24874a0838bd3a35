#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/file_blocks.h"

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

/// Whether a file, unpacked if it is a gzip, begins as the header of NIfTI-1, NIfTI-2 or Analyze
/// 7.5, in either byte order.
bool is_nifti(std::string_view head);
/// Whether a file begins as the header of an NRRD.
bool is_nrrd(std::string_view head);

/// Read the header of a file that begins so. They throw Error(input) if psivox does not read what
/// the file has, or a number is impossible. A size may still be a lie: see Scan. Sources: nifti1.h
/// and nifti2.h (nifti.nimh.nih.gov), teem.sourceforge.net/nrrd/format.html.
Header read_nifti(FileBlocks& file, bool packed);
Header read_nrrd(FileBlocks& file);
/// The file that has an NRRD's values, as its header names it; empty: the header's own.
std::string nrrd_data_file(FileBlocks& file);

}  // namespace psivox::scan
