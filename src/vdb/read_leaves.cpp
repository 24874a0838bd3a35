#include "read_leaves.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <ios>
#include <type_traits>
#include <vector>

#include "grid_types.h"
#include "tree_nodes.h"
#include "value_block.h"

namespace psivox::vdb {
namespace {

using openvdb::io::StreamMetadata;

constexpr std::size_t leaves_per_task = 64;
constexpr std::int64_t batch_bytes = 4 << 20;

/// Moves the stream from the beginning of a leaf's values behind their end.
template <typename LeafT>
void skip(const LeafT& leaf, std::istream& stream, const ValueCoding& coding) {
  leaf.getValueMask().seek(stream);
  skip_values<typename LeafT::ValueType>(stream, leaf.getValueMask(), coding);
}

/// Consecutive leaves, and where their values begin in the file.
struct Task {
  std::size_t begin, end;
  std::streamoff position;
};

template <typename LeafT>
void read(const std::vector<LeafT*>& leaves, const Task& task, const StreamMetadata& settings,
          FileBlocks& file) {
  FileBuffer buffer(file);
  std::istream stream(&buffer);
  stream.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
  StreamMetadata::Ptr metadata(new StreamMetadata(settings));  // leaves count themselves in it
  openvdb::io::setStreamMetadataPtr(stream, metadata, /*transfer=*/true);
  stream.seekg(task.position);
  for (std::size_t n = task.begin; n < task.end; ++n)
    leaves[n]->readBuffers(stream, settings.halfFloat());
}

/// A leaf's place depends on the lengths of those before it. So one thread finds the places of some
/// MiB of leaves by skipping over them, and then all threads read.
template <typename LeafT>
void read_all(const std::vector<LeafT*>& leaves, std::istream& stream, FileBuffer& buffer) {
  FileBlocks& file = buffer.file();
  StreamMetadata settings(stream);
  settings.setSeekable(true);
  settings.setBackgroundPtr(openvdb::io::getGridBackgroundValuePtr(stream));
  const ValueCoding coding{openvdb::io::getDataCompression(stream), settings.halfFloat()};
  std::vector<Task> tasks;
  std::streamoff batch_begin = stream.tellg();
  file.announce(batch_begin, 2 * batch_bytes);
  for (std::size_t n = 0; n < leaves.size();) {
    tasks.push_back({n, std::min(n + leaves_per_task, leaves.size()), stream.tellg()});
    for (; n < tasks.back().end; ++n) skip(*leaves[n], stream, coding);
    const std::streamoff here = stream.tellg();
    buffer.read_to(here);
    if (n < leaves.size() && here - batch_begin < batch_bytes) continue;
    if (n < leaves.size()) file.announce(here, 2 * batch_bytes);
    tbb::parallel_for(std::size_t{0}, tasks.size(),
                      [&](std::size_t i) { read(leaves, tasks[i], settings, file); });
    tasks.clear();
    batch_begin = here;
  }
}

}  // namespace

void read_leaves(openvdb::GridBase& grid, std::istream& stream, FileBuffer& buffer) {
  grid.apply<SupportedGrids>([&](auto& typed) {
    using GridT = std::decay_t<decltype(typed)>;
    if constexpr (std::is_same_v<typename GridT::ValueType, bool>) {
      typed.readBuffers(stream);  // bits, which are not compressed
    } else {
      const TreeNodes<typename GridT::TreeType> nodes(typed.tree());
      read_all(nodes.leaves, stream, buffer);
    }
  });
}

}  // namespace psivox::vdb
