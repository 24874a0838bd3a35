#include "points.h"

#include <cstdint>

namespace psivox::vdb {

void read_points(openvdb::points::PointDataGrid& grid, std::istream& stream,
                 openvdb::io::StreamMetadata& coding, bool whole) {
  std::uint16_t passes = 0;
  stream.read(reinterpret_cast<char*>(&passes), sizeof passes);
  if (grid.tree().leafCount() == 0) return;
  // a pass goes over all leaves; the one in the middle has the offsets, attributes follow
  const std::uint32_t wanted = whole ? passes : passes / 2u + 1;
  for (std::uint32_t pass = 0; pass < wanted; ++pass) {
    coding.setPass(std::uint32_t(passes) << 16 | pass);
    grid.tree().readBuffers(stream, coding.halfFloat());
  }
}

}  // namespace psivox::vdb
