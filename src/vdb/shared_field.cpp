// Fields that come from a guarded process: they are taken from shared memory, and checked.

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "field/index_space.h"
#include "field/leaf_values.h"
#include "psivox/error.h"
#include "reading_messages.h"
#include "survey.h"

namespace psivox::vdb {
namespace {

/// Where origins and tiles are in shared memory [bytes].
struct Layout {
  Layout(std::uint64_t leaves, std::uint64_t tiles)
      : tiles_at(leaves * sizeof(glm::ivec3)), size(tiles_at + tiles * sizeof(Tile)) {}
  std::size_t tiles_at, size;
};

/// Size of a leaf's values [bytes].
std::size_t leaf_bytes(int channels) {
  return kLeafVoxels * static_cast<std::size_t>(channels) * sizeof(float);
}

/// Writes bytes to shared memory that is empty. Faster than through a mapping, which the system
/// fills page by page. Returns them instead if the system does not let it be that large. Throws
/// std::bad_alloc.
std::string write_or_text(std::string_view bytes, int memory) {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t written = pwrite(memory, bytes.data() + at, bytes.size() - at, off_t(at));
    if (written >= 0) {
      at += static_cast<std::size_t>(written);
    } else if (errno != EINTR) {
      if (errno != EFBIG || ftruncate(memory, 0) != 0) throw std::bad_alloc();
      if (bytes.size() > guard::MessageInput::longest / 2)
        throw std::runtime_error("its values are larger than the limit of file sizes (ulimit -f)");
      return std::string(bytes);
    }
  }
  return {};
}

/// Maps the memory that was written over the whole pages of its values, so that both processes
/// share one copy.
void share(std::string_view values, int memory) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* const first = const_cast<char*>(values.data());
  if (reinterpret_cast<std::uintptr_t>(first) % page == 0 && values.size() >= page)
    mmap(first, values.size() / page * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_FIXED,
         memory, 0);
}

/// Memory that another process has written, and nobody can change from now on. Returns its size.
/// Throws std::runtime_error.
std::size_t sealed_size(int memory) {
  // Without the first two seals the size could change, without the third the values. The kernel
  // itself may hold pages for a moment, as when it looks for some to reclaim.
  int tries = 10;
  while (fcntl(memory, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE) != 0) {
    if (errno != EBUSY || --tries == 0)
      throw std::runtime_error("shared memory is still written to");
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  struct stat status {};
  if (fstat(memory, &status) != 0) throw std::runtime_error("shared memory has no size");
  return static_cast<std::size_t>(status.st_size);
}

void* mapped(void* place, std::size_t size, int access, int flags, int memory) {
  void* const map = mmap(place, size, access, flags, memory, 0);
  if (map == MAP_FAILED) throw std::bad_alloc();
  return map;
}

/// Addresses for values that come in pieces, each in memory of its own, so that it goes when its
/// pages are discarded.
class Values {
 public:
  explicit Values(std::size_t size)
      : size_(size),
        first_(mapped(nullptr, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1)) {}
  ~Values() { munmap(first_, size_); }
  Values(const Values&) = delete;
  Values& operator=(const Values&) = delete;

  const char* first() const { return static_cast<const char*>(first_); }

  /// Takes a piece from shared memory, or from a text if that is empty.
  void take(std::size_t at, std::size_t size, int memory, const std::string& text) {
    void* const place = static_cast<char*>(first_) + at;
    const std::size_t shared = sealed_size(memory);
    if ((shared == 0 ? text.size() : shared) != size)
      throw std::runtime_error("shared memory has another size");
    // a page that is not whole could not be discarded
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t whole = shared / page * page, rest = size - whole;
    if (whole > 0) mapped(place, whole, PROT_READ, MAP_SHARED | MAP_POPULATE | MAP_FIXED, memory);
    if (rest == 0) return;
    void* const last = static_cast<char*>(place) + whole;
    mapped(last, rest, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1);
    if (shared == 0)
      std::memcpy(last, text.data(), size);
    else if (pread(memory, last, rest, static_cast<off_t>(whole)) != static_cast<ssize_t>(rest))
      throw std::runtime_error("shared memory cannot be read");
  }

 private:
  std::size_t size_;
  void* first_;
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
                     /*infinite=*/stored, field.absent),
            bad_values);
  if (stored) return;
  std::atomic<bool> good = true;
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, field.leaves.size(), 64), [&](const auto& range) {
        for (std::size_t n = range.begin(); n != range.end(); ++n)
          if (!all_good(
                  {field.leaves[n].values, kLeafVoxels * static_cast<std::size_t>(field.channels)},
                  role, /*infinite=*/false, field.absent))
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

void write_places(const Field& field, int memory, FieldFacts& facts) {
  std::string bytes;
  bytes.reserve(Layout(field.leaves.size(), field.tiles.size()).size);
  for (const Leaf& leaf : field.leaves)
    bytes.append(reinterpret_cast<const char*>(&leaf.origin), sizeof leaf.origin);
  bytes.append(reinterpret_cast<const char*>(field.tiles.data()),
               field.tiles.size() * sizeof(Tile));
  facts.bytes = write_or_text(bytes, memory);
}

std::string write_values(const Field& field, const ValuesRequest& request, int memory) {
  if (request.first > field.leaves.size() || request.count > field.leaves.size() - request.first)
    throw std::runtime_error("an unknown request");
  const auto leaves = std::span(field.leaves).subspan(request.first, request.count);
  if (leaves.empty()) return {};
  const std::size_t size = leaf_bytes(field.channels);
  const auto first = [](const Leaf& leaf) { return reinterpret_cast<const char*>(leaf.values); };
  const auto follows = [&](const Leaf& a, const Leaf& b) { return first(a) + size == first(b); };
  if (std::ranges::adjacent_find(leaves, std::not_fn(follows)) == leaves.end()) {
    const std::string_view values(first(leaves.front()), leaves.size() * size);
    std::string text = write_or_text(values, memory);
    if (text.empty()) share(values, memory);
    return text;
  }
  std::string copies;
  copies.reserve(leaves.size() * size);
  for (const Leaf& leaf : leaves) copies.append(first(leaf), size);
  return write_or_text(copies, memory);
}

void take_places(FieldFacts& facts, int memory) {
  Field& field = facts.field;
  const std::size_t shared = sealed_size(memory);
  const std::size_t size = shared > 0 ? shared : facts.bytes.size();
  const bool possible = (field.channels == 1 || field.channels == 3) &&
                        // so that sums do not overflow
                        facts.leaves <= size / sizeof(glm::ivec3) &&
                        facts.tiles <= size / sizeof(Tile);
  const Layout layout(facts.leaves, facts.tiles);
  if (!possible || layout.size != size) throw std::runtime_error("shared memory has another size");
  field.leaves.resize(facts.leaves);
  field.tiles.resize(facts.tiles);
  if (size == 0) return;
  const char* bytes = facts.bytes.data();
  if (shared > 0)
    bytes = static_cast<const char*>(
        mapped(nullptr, size, PROT_READ, MAP_SHARED | MAP_POPULATE, memory));
  const auto* const origins = reinterpret_cast<const glm::ivec3*>(bytes);
  for (std::size_t n = 0; n < facts.leaves; ++n) field.leaves[n] = {origins[n], nullptr};
  if (facts.tiles > 0)
    std::memcpy(field.tiles.data(), bytes + layout.tiles_at, facts.tiles * sizeof(Tile));
  if (shared > 0) munmap(const_cast<char*>(bytes), size);
}

void take_values(Field& field, const AskValues& ask) {
  const std::size_t leaf = leaf_bytes(field.channels), count = field.leaves.size();
  if (count == 0) return;
  const auto values = std::make_shared<Values>(count * leaf);
  constexpr std::size_t at_once = 2048;  // whole pages: 4 MiB of scalars
  for (std::size_t first = 0; first < count; first += at_once) {
    const std::size_t some = std::min(at_once, count - first);
    const guard::Descriptor memory = shared_memory();
    const std::string text = ask({.grid = field.name, .first = first, .count = some}, memory.get());
    values->take(first * leaf, some * leaf, memory.get(), text);
  }
  for (std::size_t n = 0; n < count; ++n)
    field.leaves[n].values = reinterpret_cast<const float*>(values->first() + n * leaf);
  field.storage = values;
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
  const glm::ivec3 size = field.domain().max - field.domain().min;
  require(
      (field.margin == 0 || field.margin == 1) && glm::all(glm::greaterThan(size, glm::ivec3(0))),
      "an impossible domain");
  require(has_volume(field.world_from_index), "an impossible transform");
  require(std::isfinite(field.half_width) && field.half_width >= 0, "an impossible half width");
  require(std::isfinite(field.replaced.least), "an impossible least value");
  check_range(field.active_range);
  check_range(field.stored_range);
  require(!field.survey || is_possible(*field.survey), "an impossible survey");
  for (const auto& [percent, value] : field.active_percentiles)
    require(std::isfinite(percent) && !std::isnan(value), "an impossible percentile");
  check_places(field);
  check_values(field, role, facts.stored());
}

}  // namespace psivox::vdb
