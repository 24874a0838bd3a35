#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "grid_file.h"
#include "nano_tree.h"

namespace psivox::vdb {

/// Whether a file's first bytes are those of a .nvdb.
bool is_nano(FileBlocks& file);

/// A .nvdb open for reading, its directory read. The file is a sequence of segments: a header, an
/// entry for each grid, and the bytes of each grid, which are compressed as one block. Since
/// version 32.6 a file can also be a sequence of bare grids.
class NanoFile final : public GridFile {
 public:
  /// Throws Error(input) if the file is damaged before its first grid, or of another major version
  /// than nano_major_version().
  explicit NanoFile(std::shared_ptr<FileBlocks> file, Progress progress = {});

  MetadataText metadata_of(const GridEntry& entry) override;
  std::unique_ptr<FileGrid> open(const GridEntry& entry, bool marked) override;

  /// What is stored of an entry.
  struct Stored {
    std::uint64_t memory = 0;  ///< size of the grid [bytes]
    std::uint64_t bytes = 0;   ///< its size in the file [bytes]
    std::uint64_t at = 0;      ///< its place in the file [bytes]
    std::uint32_t type = 0, grid_class = 0;
    std::uint16_t codec = 0;
  };
  const Stored& stored(const GridEntry& entry) const;

  /// A grid's bytes, decompressed, behind the owner of their memory. Throws openvdb::IoError if the
  /// file is damaged, Error(memory) if they need more memory than there is.
  std::pair<std::shared_ptr<const void>, NanoBytes> unpacked(const GridEntry& entry);

 private:
  void read_segment();
  void read_bare_grid();
  void read_entry(std::uint16_t codec);
  void add_entry(std::string name, const Stored& grid);  ///< the name may end before its text
  void place_entries(std::size_t first, std::uint64_t at);
  void unpack(const Stored& stored, char* to);

  std::vector<Stored> stored_;  ///< of each entry
};

}  // namespace psivox::vdb
