#pragma once

#include <glm/mat4x4.hpp>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "psivox/vdb.h"

namespace psivox::vdb {

/// Metadata as text, by name.
using MetadataText = std::map<std::string, std::string>;

/// What takes a grid's voxels to world space.
struct Transform {
  std::string map = "AffineMap";          ///< OpenVDB's name of its type
  glm::dmat4 world_from_index{1};         ///< in glm's convention, unless it is a frustum
  std::shared_ptr<const void> frustum{};  ///< OpenVDB's transform if it is a frustum's, else null

  bool is_linear() const { return !frustum; }
};

/// Classes of grids, as OpenVDB names them.
inline constexpr std::string_view level_set_class = "level set", staggered_class = "staggered",
                                  fog_class = "fog volume", unknown_class = "unknown";
/// The class that metadata tell.
std::string_view class_in(const MetadataText& metadata);

/// The place of a grid by what its writer has noted: OpenVDB's statistics of the file.
GridPlace place_in(const MetadataText& metadata, const Transform& transform);

/// OpenVDB's type of grids with such values, by GridInfo::value_type: float, vec3s, ...
std::string grid_type_of(std::string_view value_type);
/// GridInfo::value_type; empty if it is not supported.
std::string value_type_of(std::string_view grid_type);
/// Channels of a grid type: 1, 3, or 0 if it is not supported.
int channels_of(std::string_view grid_type);
/// Grids of points, whose voxels become the numbers of points in them; and of active voxels without
/// values, which become 1.
bool is_points(std::string_view grid_type);
bool is_mask(std::string_view grid_type);
/// Why a grid of an unsupported type cannot be rendered, as the rest of a sentence.
std::string unsupported_type(const std::string& grid_type);

/// A grid without its tree.
struct GridHead {
  std::string type{};  ///< OpenVDB's: Tree_float_5_4_3
  MetadataText metadata{};
  std::string_view grid_class = unknown_class;
  Transform transform{};
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
