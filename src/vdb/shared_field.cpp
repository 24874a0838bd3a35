#include "shared_field.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

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

/// A mapping of shared memory.
class Mapping {
 public:
  Mapping(int memory, std::size_t size, bool writable)
      : size_(size),
        bytes_(mmap(nullptr, size, writable ? PROT_READ | PROT_WRITE : PROT_READ,
                    MAP_SHARED | MAP_POPULATE, memory, 0)) {
    if (bytes_ == MAP_FAILED) throw std::bad_alloc();
  }
  ~Mapping() { munmap(bytes_, size_); }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  char* bytes() const { return static_cast<char*>(bytes_); }

 private:
  std::size_t size_;
  void* bytes_;
};

void write(const Field& field, const Layout& layout, std::size_t leaf, char* bytes) {
  auto* const origins = reinterpret_cast<glm::ivec3*>(bytes + layout.origins);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, field.leaves.size(), 64),
                    [&](const auto& range) {
                      for (std::size_t n = range.begin(); n != range.end(); ++n) {
                        if (leaf > 0) std::memcpy(bytes + n * leaf, field.leaves[n].values, leaf);
                        origins[n] = field.leaves[n].origin;
                      }
                    });
  if (!field.tiles.empty())
    std::memcpy(bytes + layout.tiles_at, field.tiles.data(), field.tiles.size() * sizeof(Tile));
}

}  // namespace

Descriptor shared_memory() {
  Descriptor memory(memfd_create("psivox field", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!memory) throw Error(ExitCode::failure, "the system has no memory to share");
  return memory;
}

void write_shared(const Field& field, int memory, FieldFacts& facts) {
  const std::size_t leaf = leaf_bytes(field.channels, field.reader != nullptr);
  const Layout layout(leaf, field.leaves.size(), field.tiles.size());
  if (layout.size == 0) return;
  // at once: page by page takes longer, and a lack of memory would come as a signal
  if (fallocate(memory, 0, 0, static_cast<off_t>(layout.size)) == 0) {
    const Mapping mapping(memory, layout.size, /*writable=*/true);
    write(field, layout, leaf, mapping.bytes());
  } else if (errno == EFBIG && layout.size < MessageInput::longest / 2) {
    facts.bytes.resize(layout.size);
    write(field, layout, leaf, facts.bytes.data());
  } else if (errno == EFBIG) {
    throw std::runtime_error("its values are larger than the limit of file sizes (ulimit -f)");
  } else {
    throw std::bad_alloc();
  }
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
    const auto mapping = std::make_shared<const Mapping>(memory, size, /*writable=*/false);
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
