#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <istream>

#include "survey.h"

namespace psivox::vdb {

/// How many points each voxel of a leaf has.
using PointCounts = std::array<std::int32_t, kLeafVoxels>;
using TakeCounts = std::function<void(std::size_t leaf, const PointCounts& counts)>;

/// Reads the numbers of points in a grid's voxels, leaf by leaf. The stream is behind the topology
/// of a grid of points (OpenVDB's PointDataGrid, file format 224 or later). Attributes of points
/// are passed over, so that their types and codecs do not matter. Leaves the stream before the
/// attributes' values, and returns how many bytes those take. Throws if the file is damaged.
std::int64_t read_point_counts(std::size_t leaves, std::istream& stream, const TakeCounts& take);

}  // namespace psivox::vdb
