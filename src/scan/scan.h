#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/file_blocks.h"
#include "psivox/field.h"
#include "psivox/progress.h"
#include "scan/header.h"

namespace psivox::scan {

class ValueStream;

/// An open NIfTI or NRRD file. Its functions may be called from several threads.
class Scan {
 public:
  /// `data`: the file at data_path(), or null if there is none. Throws Error(input) if the header
  /// claims more values than the file can hold, more than 65,536 frames, or voxels without a
  /// volume.
  Scan(Header header, std::shared_ptr<FileBlocks> file, std::shared_ptr<FileBlocks> data);
  ~Scan();

  const Header& header() const { return header_; }

  /// One frame, under that name. Voxels other than 0 are active. Values are rounded to float.
  /// Frames in their order are read fastest: a gzip is then unpacked once. Throws Error(input),
  /// Error(memory).
  Field read(std::int64_t frame, const std::string& name, const Progress& progress) const;

 private:
  /// Opens a stream anew if it is beyond the value.
  void start_at(std::size_t stream, std::int64_t value) const;

  Header header_;
  std::shared_ptr<FileBlocks> file_;                           ///< of the values
  mutable std::mutex mutex_;                                   ///< of what follows
  mutable std::vector<std::unique_ptr<ValueStream>> streams_;  ///< see Scan::read
};

/// The file's scan; null if it is of another format. Throws Error(input).
std::unique_ptr<Scan> open_scan(std::shared_ptr<FileBlocks> file, std::shared_ptr<FileBlocks> data);

}  // namespace psivox::scan
