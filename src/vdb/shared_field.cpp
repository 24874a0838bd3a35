#include "shared_field.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "psivox/error.h"
#include "sanitise.h"

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

/// A mapping of shared memory, to be read.
class Mapping {
 public:
  Mapping(int memory, std::size_t size)
      : size_(size), bytes_(mmap(nullptr, size, PROT_READ, MAP_SHARED | MAP_POPULATE, memory, 0)) {
    if (bytes_ == MAP_FAILED) throw std::bad_alloc();
  }
  ~Mapping() { munmap(bytes_, size_); }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  const char* bytes() const { return static_cast<const char*>(bytes_); }

 private:
  std::size_t size_;
  void* bytes_;
};

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
    if (size > 0) parts_.push_back({const_cast<void*>(bytes), size});
  }

  std::vector<glm::ivec3> origins_;
  std::vector<iovec> parts_;
};

}  // namespace

Descriptor shared_memory() {
  Descriptor memory(memfd_create("psivox field", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!memory) throw Error(ExitCode::failure, "the system has no memory to share");
  return memory;
}

void write_shared(const Field& field, int memory, FieldFacts& facts) {
  const std::size_t leaf = leaf_bytes(field.channels, field.reader != nullptr);
  const Layout layout(leaf, field.leaves.size(), field.tiles.size());
  const int error = Parts(field, leaf).write(memory);
  if (error == 0) return;
  if (error != EFBIG || ftruncate(memory, 0) != 0) throw std::bad_alloc();
  if (layout.size > MessageInput::longest / 2)
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
  std::shared_ptr<const void> storage;
  const char* bytes = nullptr;
  if (in_message) {
    const auto text = std::make_shared<const std::string>(std::move(facts.bytes));
    bytes = text->data();
    storage = text;
  } else {
    const auto mapping = std::make_shared<const Mapping>(memory, size);
    bytes = mapping->bytes();
    storage = mapping;
  }
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

}  // namespace psivox::vdb
