#pragma once

#include <string>
#include <vector>

#include "file_metadata.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

/// What a file tells without its grids being read. The lists are parallel, in file order.
struct FileFacts {
  std::vector<std::string> names;       ///< as VdbFile::read takes them
  std::vector<std::string> base_names;  ///< as the file has them: names may repeat
  std::vector<int> channels;            ///< 0 if the grid cannot be read
  std::vector<std::string> value_types;
  std::vector<std::string> classes;
  MetadataText metadata;
  std::string z_up;
};

/// What VdbFile does with an open file: in this process (InPlaceReader), or in a guarded one
/// (GuardedReader). Its functions may be called from several threads. See VdbFile for them.
class Reader {
 public:
  Reader() = default;
  virtual ~Reader() = default;
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  virtual FileFacts facts() = 0;
  virtual std::vector<GridInfo> info(bool values) = 0;
  virtual GridContent content(const std::string& grid) = 0;
  virtual Field read(const std::string& grid, const ReadOptions& options) = 0;
};

}  // namespace psivox::vdb
