#pragma once

#include <array>
#include <cstring>
#include <glm/mat4x4.hpp>
#include <istream>
#include <map>
#include <string>
#include <string_view>

#include "psivox/vdb.h"
#include "values.h"

namespace psivox::vdb {

/// Metadata as text, by name.
using MetadataText = std::map<std::string, std::string>;

/// Reads metadata. The stream throws if a length is beyond its end. Metadata for delayed loading
/// are left out; `delayed_load` gets their bytes. Throws if a value is shorter than its type.
MetadataText read_metadata(std::istream& stream, std::string* delayed_load = nullptr);

/// A string, which is a length and that many bytes.
std::string read_string(std::istream& stream);
void skip_string(std::istream& stream);

/// What takes a grid's voxels to world space.
struct Transform {
  std::string map = "AffineMap";   ///< OpenVDB's name of its type
  std::string frustum{};           ///< what a file has of a frustum behind that name
  glm::dmat4 world_from_index{1};  ///< in glm's convention, unless it is a frustum

  bool is_linear() const { return frustum.empty(); }
};

/// Reads a transform, as files have it since format 219, for frustums 221. Throws if its type is
/// unknown or its matrix is not affine.
Transform read_transform(std::istream& stream);

/// Classes of grids, as OpenVDB names them.
inline constexpr std::string_view level_set_class = "level set", staggered_class = "staggered",
                                  fog_class = "fog volume", unknown_class = "unknown";
/// The class that metadata tell.
std::string_view class_in(const MetadataText& metadata);

/// The place of a grid by what its writer has noted: OpenVDB's statistics of the file.
GridPlace place_in(const MetadataText& metadata, const Transform& transform);

/// A grid without its tree.
struct GridHead {
  int type = 0;  ///< of its values, see with_value_type
  MetadataText metadata{};
  std::string_view grid_class = unknown_class;
  Transform transform{};

  template <typename ValueT>
  void set_background(const ValueT& value) {
    std::memcpy(background_.data(), &value, sizeof value);
  }
  template <typename ValueT>
  ValueT background() const {
    ValueT value;
    std::memcpy(&value, background_.data(), sizeof value);
    return value;
  }

 private:
  std::array<char, sizeof(glm::dvec3)> background_{};  ///< known once the topology is read
};

struct GridSummary;

/// A level set in OpenVDB's sense that psivox can turn into fog: its class says so, its values are
/// floating-point scalars, and its background is the half width of its band.
bool is_level_set(const GridHead& head, const GridSummary& summary);
/// A grid of the same type and class whose background is 0, as a fog's is.
bool is_fog_of_wrong_class(const GridHead& head, const GridSummary& summary);

/// Whether it has a background other than 0, and is no level set, whose background is its half
/// width.
bool has_background(const GridHead& head, const GridSummary& summary);

/// The background as text: 1, or (1, 1, 1).
std::string background_text(const GridSummary& summary);

/// Why the grid cannot be rendered, as the rest of a sentence that begins with its name; empty if
/// it can. Reading and `psivox info` both take these rules from here.
std::string problem_of(const Transform& transform, const GridSummary& summary);

/// The same of a level set whose distances are positive inside; empty if it has none.
std::string problem_of_distances(const GridHead& head, const GridSummary& summary);

}  // namespace psivox::vdb
