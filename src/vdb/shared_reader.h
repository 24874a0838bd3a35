#pragma once

#include <memory>
#include <mutex>

#include "vdb/reader.h"

namespace psivox::vdb {

/// A file's reader. Frames of the file share it while somebody holds it: one after another they are
/// unpacked once.
struct SharedReader {
  std::shared_ptr<FileBlocks> file;
  std::mutex mutex{};   ///< of what a frame reads
  Progress progress{};  ///< of who reads now
  std::unique_ptr<Reader> reader{};
};

/// While a frame reads, its progress is the reader's.
class Turn {
 public:
  Turn(SharedReader& shared, Progress& own);
  ~Turn();

 private:
  std::lock_guard<std::mutex> lock_;
  SharedReader& shared_;
  Progress& own_;
};

/// A file's reader; that of a file that is open already for one of its frames. Throws Error(input).
std::shared_ptr<SharedReader> reader_of(const FrameOfFile& one, Progress progress);

}  // namespace psivox::vdb
