// Fields that come from a guarded process: they are taken from shared memory, and checked.

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "field/index_space.h"
#include "grid_types.h"
#include "psivox/error.h"
#include "psivox/leaf_values.h"
#include "reading_messages.h"
#include "survey.h"

namespace psivox::vdb {
namespace {

/// Where the parts of a field are in shared memory: values, origins, tiles. [bytes]
struct Layout {
  Layout(std::size_t leaf, std::uint64_t leaves, std::uint64_t tiles)
      : origins(leaves * leaf),
        tiles_at(origins + leaves * sizeof(glm::ivec3)),
        size(tiles_at + tiles * sizeof(Tile)) {}
  std::size_t origins, tiles_at, size;
};

/// Size of a leaf's values in shared memory [bytes].
std::size_t leaf_bytes(int channels, bool stored) {
  return stored ? 0 : kLeafVoxels * static_cast<std::size_t>(channels) * sizeof(float);
}

/// Shared memory, mapped to be read.
std::shared_ptr<const char> mapped(int memory, std::size_t size) {
  void* const bytes = mmap(nullptr, size, PROT_READ, MAP_SHARED | MAP_POPULATE, memory, 0);
  if (bytes == MAP_FAILED) throw std::bad_alloc();
  return {static_cast<const char*>(bytes),
          [size](const char* mapping) { munmap(const_cast<char*>(mapping), size); }};
}

/// The parts of a field in the order of its layout. They must live as long.
class Parts {
 public:
  Parts(const Field& field, std::size_t leaf) {
    if (leaf > 0)
      for (const Leaf& some : field.leaves) add(some.values, leaf);
    origins_.reserve(field.leaves.size());
    for (const Leaf& some : field.leaves) origins_.push_back(some.origin);
    add(origins_.data(), origins_.size() * sizeof(glm::ivec3));
    add(field.tiles.data(), field.tiles.size() * sizeof(Tile));
  }

  /// Writes all to a file that is empty. Faster than through a mapping, which the system fills page
  /// by page. Returns an error number or 0.
  int write(int file) {
    std::span<iovec> rest = parts_;
    std::int64_t at = 0;
    while (!rest.empty()) {
      constexpr std::size_t most = 512;  // 1 MiB of scalars
      const ssize_t written =
          pwritev(file, rest.data(), static_cast<int>(std::min(most, rest.size())), at);
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return errno;
      at += written;
      for (auto left = static_cast<std::size_t>(written); !rest.empty();) {
        iovec& first = rest.front();
        const std::size_t done = std::min(left, first.iov_len);
        first = {static_cast<char*>(first.iov_base) + done, first.iov_len - done};
        left -= done;
        if (first.iov_len > 0) break;
        rest = rest.subspan(1);
      }
    }
    return 0;
  }

  std::string text() const {
    std::string text;
    for (const iovec& part : parts_)
      text.append(static_cast<const char*>(part.iov_base), part.iov_len);
    return text;
  }

 private:
  void add(const void* bytes, std::size_t size) {
    if (!parts_.empty() &&
        static_cast<const char*>(parts_.back().iov_base) + parts_.back().iov_len == bytes)
      parts_.back().iov_len += size;  // leaves mostly lie one behind another
    else if (size > 0)
      parts_.push_back({const_cast<void*>(bytes), size});
  }

  std::vector<glm::ivec3> origins_;
  std::vector<iovec> parts_;
};

constexpr const char* bad_values = "values are not finite, or negative";

void require(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(what);
}

/// A cube of leaves of one width, in a list in the tree's order.
struct Cube {
  TreeOrder order;
  glm::ivec3 origin;
};

void check_order(const std::vector<Cube>& cubes, int width) {
  for (const Cube& cube : cubes)
    for (int axis = 0; axis < 3; ++axis)
      require(cube.origin[axis] % width == 0, "a block lies between the places of blocks");
  for (std::size_t n = 1; n < cubes.size(); ++n)
    require(cubes[n - 1].order < cubes[n].order, "blocks are not in order");
}

/// No small cube may lie in a wide one. All that lie in it would follow its origin.
void check_apart(const std::vector<Cube>& wide, int width, const std::vector<Cube>& small) {
  for (const Cube& cube : wide) {
    const auto first = std::ranges::lower_bound(small, cube.order, std::less{}, &Cube::order);
    const bool inside = first != small.end() && (first->origin & ~(width - 1)) == cube.origin;
    require(!inside, "blocks overlap");
  }
}

void check_places(const Field& field) {
  constexpr std::array<int, 4> widths{8, 8, 128, 4096};  // of leaves, then of tiles
  std::array<std::vector<Cube>, 4> cubes;
  cubes[0].reserve(field.leaves.size());
  for (const Leaf& leaf : field.leaves) cubes[0].push_back({tree_order(leaf.origin), leaf.origin});
  for (const Tile& tile : field.tiles) {
    const auto width = std::find(widths.begin() + 1, widths.end(), tile.width);
    require(width != widths.end(), "a tile has an impossible width");
    cubes[static_cast<std::size_t>(width - widths.begin())].push_back(
        {tree_order(tile.origin), tile.origin});
  }
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    check_order(cubes[i], widths[i]);
    for (std::size_t smaller = 0; smaller < i; ++smaller)
      check_apart(cubes[i], widths[i], cubes[smaller]);
  }
}

void check_range(const std::optional<glm::vec2>& range) {
  require(!range || !(std::isnan(range->x) || std::isnan(range->y)), "an impossible range");
}

void check_values(const Field& field, GridRole role, bool stored) {
  for (const Tile& tile : field.tiles)
    require(all_good({&tile.value.x, static_cast<std::size_t>(field.channels)}, role,
                     /*infinite=*/field.survey.has_value()),
            bad_values);
  if (stored) return;
  std::atomic<bool> good = true;
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, field.leaves.size(), 64), [&](const auto& range) {
        for (std::size_t n = range.begin(); n != range.end(); ++n)
          if (!all_good(
                  {field.leaves[n].values, kLeafVoxels * static_cast<std::size_t>(field.channels)},
                  role))
            good = false;
      });
  require(good, bad_values);
}

}  // namespace

guard::Descriptor shared_memory() {
  guard::Descriptor memory(memfd_create("psivox field", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!memory) throw Error(ExitCode::failure, "the system has no memory to share");
  return memory;
}

void write_shared(const Field& field, int memory, FieldFacts& facts) {
  const std::size_t leaf = leaf_bytes(field.channels, field.reader != nullptr);
  const Layout layout(leaf, field.leaves.size(), field.tiles.size());
  const int error = Parts(field, leaf).write(memory);
  if (error == 0) return;
  if (error != EFBIG || ftruncate(memory, 0) != 0) throw std::bad_alloc();
  if (layout.size > guard::MessageInput::longest / 2)
    throw std::runtime_error("its values are larger than the limit of file sizes (ulimit -f)");
  facts.bytes = Parts(field, leaf).text();
}

void take_shared(FieldFacts& facts, int memory) {
  Field& field = facts.field;
  // Without the first two seals the size could change, without the third the values.
  if (fcntl(memory, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE) != 0)
    throw std::runtime_error("shared memory is still written to");
  struct stat status {};
  if (fstat(memory, &status) != 0) throw std::runtime_error("shared memory has no size");
  const bool in_message = status.st_size == 0;
  const std::uint64_t size =
      in_message ? facts.bytes.size() : static_cast<std::uint64_t>(status.st_size);
  const std::size_t leaf = leaf_bytes(field.channels, facts.stored);
  const bool possible = (field.channels == 1 || field.channels == 3) &&
                        // so that sums do not overflow
                        facts.leaves <= size / sizeof(glm::ivec3) &&
                        facts.tiles <= size / sizeof(Tile);
  const Layout layout(leaf, facts.leaves, facts.tiles);
  if (!possible || layout.size != size) throw std::runtime_error("shared memory has another size");
  if (size == 0) return;
  std::shared_ptr<const char> storage;
  if (in_message) {
    const auto text = std::make_shared<const std::string>(std::move(facts.bytes));
    storage = {text, text->data()};
  } else {
    storage = mapped(memory, size);
  }
  const char* const bytes = storage.get();
  const auto* const origins = reinterpret_cast<const glm::ivec3*>(bytes + layout.origins);
  field.leaves.resize(facts.leaves);
  for (std::size_t n = 0; n < facts.leaves; ++n)
    field.leaves[n] = {origins[n],
                       leaf > 0 ? reinterpret_cast<const float*>(bytes + n * leaf) : nullptr};
  field.tiles.resize(facts.tiles);
  if (facts.tiles > 0)
    std::memcpy(field.tiles.data(), bytes + layout.tiles_at, facts.tiles * sizeof(Tile));
  if (!facts.stored) field.storage = storage;
}

bool is_possible(const ValueSurvey& survey) {
  if (!std::isfinite(survey.largest) || survey.largest < 0) return false;
  for (const Extent& extent : {survey.all, survey.active, survey.in_box})
    if (std::isnan(extent.min) || std::isnan(extent.max)) return false;
  return true;
}

void check_field(const FieldFacts& facts, GridRole role) {
  const Field& field = facts.field;
  require(field.channels == 1 || field.channels == 3, "an impossible number of channels");
  require(!field.active_box.empty() && !too_large(field.active_box), "an impossible box");
  require(has_volume(field.world_from_index), "an impossible transform");
  require(std::isfinite(field.half_width) && field.half_width >= 0, "an impossible half width");
  require(std::isfinite(field.replaced.least), "an impossible least value");
  check_range(field.active_range);
  check_range(field.stored_range);
  require(!field.survey || (facts.stored && is_possible(*field.survey)), "an impossible survey");
  require(!facts.stored || field.survey || (field.active_range && field.stored_range), "no ranges");
  for (const auto& [percent, value] : field.active_percentiles)
    require(std::isfinite(percent) && !std::isnan(value), "an impossible percentile");
  check_places(field);
  check_values(field, role, facts.stored);
}

}  // namespace psivox::vdb
