#include "archive.h"

#include <cstdlib>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "values.h"

namespace psivox::vdb {
namespace {

/// How the values of an attribute of one leaf are stored.
struct Attribute {
  bool uniform, paged;
  std::int64_t bytes;
};

/// The leaves of PointDataLeafNode::writeBuffers. A pass goes over all leaves: the sizes of their
/// offsets, the descriptions of their attributes, for each attribute the lengths of the pages that
/// several leaves share, the offsets, and for each attribute its values.
class PointReader {
 public:
  PointReader(std::size_t leaves, std::istream& stream) : leaves_(leaves), stream_(stream) {}

  std::int64_t read(const TakeCounts& take_counts) {
    constexpr int passes_beside = 4;  // two for each attribute, and these
    const int passes = take<std::uint16_t>(stream_);
    if (passes < passes_beside) throw std::runtime_error("its points have too few parts");
    skip(leaves_ * sizeof(std::uint16_t));
    read_descriptions();
    for (int n = 0; n < (passes - passes_beside) / 2; ++n) read_pages(std::size_t(n));
    for (std::size_t n = 0; n < leaves_; ++n) take_counts(n, read_counts());
    return rest_;
  }

 private:
  /// Never back, so that reading ends.
  void skip(std::uint64_t bytes) {
    if (bytes > std::uint64_t(std::numeric_limits<std::int64_t>::max()))
      throw std::runtime_error("a length in its points is impossible");
    stream_.seekg(std::int64_t(bytes), std::ios_base::cur);
  }

  void read_descriptions() {
    constexpr std::uint8_t of_all = 1, more = 2;
    bool shared = false;
    std::uint64_t count = 0;
    for (std::size_t n = 0; n < leaves_; ++n) {
      if (!shared) {
        const auto header = take<std::uint8_t>(stream_);
        count = read_descriptor();
        shared = header & of_all;
        if (header & more) skip(take<std::uint64_t>(stream_));
        if (header > (of_all | more)) throw std::runtime_error("its points have an unknown format");
      }
      for (std::uint64_t i = 0; i < count; ++i) attributes_.push_back(read_attribute());
      ends_.push_back(attributes_.size());
    }
  }

  /// Returns the number of attributes. It is one leaf's, or that of all from there on.
  std::uint64_t read_descriptor() {
    const auto count = take<std::uint64_t>(stream_);
    for (std::uint64_t n = 0; n < count; ++n)
      for (int part = 0; part < 2; ++part) skip_string(stream_);  // type and codec
    skip_names(count);
    skip_names(take<std::uint64_t>(stream_));  // of groups of points
    read_metadata(stream_);                    // defaults
    return count;
  }

  /// Each with its number.
  void skip_names(std::uint64_t count) {
    for (; count > 0; --count) {
      skip_string(stream_);
      skip(sizeof(std::uint64_t));
    }
  }

  Attribute read_attribute() {
    constexpr std::uint8_t strided = 1, uniform = 2, paged = 8, unknown = 16;
    constexpr std::uint64_t head = 6;  // that counts as values
    constexpr std::uint64_t most = std::uint64_t{1} << 40;
    const auto bytes = take<std::uint64_t>(stream_) - head;
    take<std::uint8_t>(stream_);  // what the attribute is for
    const auto stored = take<std::uint8_t>(stream_);
    take<std::uint32_t>(stream_);  // number of points
    if (stored & strided) take<std::uint32_t>(stream_);
    if (stored >= unknown || bytes > most)
      throw std::runtime_error("an attribute of its points has an unknown format");
    return {(stored & uniform) != 0, (stored & paged) != 0, std::int64_t(bytes)};
  }

  /// The pages of an attribute, whose lengths stand where the first leaf of each has its turn.
  void read_pages(std::size_t number) {
    std::int64_t page = 0, used = 0;
    for (std::size_t n = 0, begin = 0; n < ends_.size(); begin = ends_[n++]) {
      if (begin + number >= ends_[n]) continue;
      const Attribute& attribute = attributes_[begin + number];
      if (!attribute.paged) {
        rest_ += attribute.bytes + (attribute.uniform ? 0 : 1);
        continue;
      }
      if (used == page) {
        const std::int64_t stored = take<std::int32_t>(stream_);  // negative: not compressed
        page = stored > 0 ? take<std::int32_t>(stream_) : -stored;
        used = 0;
        rest_ += std::abs(stored);
      }
      used += attribute.bytes;
      if (used > page)
        throw std::runtime_error("an attribute of its points is longer than its page");
    }
  }

  /// From the offsets behind each voxel's last point.
  PointCounts read_counts() {
    constexpr std::uint16_t not_compressed = std::numeric_limits<std::uint16_t>::max();
    std::array<std::uint32_t, kLeafVoxels> ends;
    constexpr std::size_t size = kLeafVoxels * sizeof(std::uint32_t);
    skip(sizeof(LeafMask));
    const auto length = take<std::uint16_t>(stream_);
    std::string stored(length == not_compressed ? size : length, '\0');
    stream_.read(stored.data(), std::streamsize(stored.size()));
    if (length == not_compressed)
      std::memcpy(ends.data(), stored.data(), size);
    else
      expand_blosc(stored, reinterpret_cast<char*>(ends.data()), size);
    return point_counts([&](std::size_t i) { return ends[i]; });
  }

  std::size_t leaves_;
  std::istream& stream_;
  std::vector<Attribute> attributes_;  ///< of the first leaf, of the second, ...
  std::vector<std::size_t> ends_;      ///< of each leaf's attributes
  std::int64_t rest_ = 0;              ///< bytes of all attributes' values
};

}  // namespace

std::int64_t read_point_counts(std::size_t leaves, std::istream& stream, const TakeCounts& take) {
  return PointReader(leaves, stream).read(take);
}

}  // namespace psivox::vdb
