#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/file_blocks.h"
#include "file_metadata.h"
#include "psivox/progress.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

/// What a file tells of a grid that has not been read.
struct GridFacts {
  std::string name;       ///< as VdbFile::read takes it
  std::string base_name;  ///< as the file has it: names may repeat
  int channels = 0;       ///< 0 if the grid cannot be read
  std::string value_type, grid_class;
};

/// What a file tells without its grids being read.
struct FileFacts {
  std::vector<GridFacts> grids;  ///< in file order
  MetadataText metadata;
  std::string z_up;
};

/// What VdbFile does with an open file: in this process (InPlaceReader, FieldReader), or in a
/// guarded one (GuardedReader). Its functions may be called from several threads. See VdbFile for
/// them.
class Reader {
 public:
  Reader() = default;
  virtual ~Reader() = default;
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  virtual FileFacts facts() = 0;
  /// The row of a grid, or of all: "".
  virtual std::vector<GridInfo> info(const std::string& grid, bool values) = 0;
  virtual GridContent content(const std::string& grid) = 0;
  virtual Field read(const std::string& grid, const ReadOptions& options) = 0;
};

struct Voxels;

/// Reads in this process. Each read has a stream of its own, so that reads may run in several
/// threads and a failed one does not affect the others.
class InPlaceReader final : public Reader {
 public:
  explicit InPlaceReader(std::shared_ptr<FileBlocks> file, Progress progress = {});

  FileFacts facts() override;
  std::vector<GridInfo> info(const std::string& grid, bool values) override;
  GridContent content(const std::string& grid) override;
  Field read(const std::string& grid, const ReadOptions& options) override;

 private:
  /// The field that was read last, as long as somebody holds it, if it has the same values for
  /// these options. A scene in an automatic look reads its density for one role and then another.
  std::optional<Field> last_field(const std::string& name, const ReadOptions& options);

  std::shared_ptr<FileBlocks> file_;  ///< shared with the readers of fields
  Progress progress_;

  std::mutex mutex_;  ///< of what follows
  Field last_;        ///< without storage, which follows
  std::weak_ptr<const Voxels> last_voxels_;
  GridRole last_role_ = GridRole::attenuation;
};

/// The reader of a file's format, by the file's first bytes, in this process. `data`: the file of
/// values that the file says lie beside it (scan::data_path), or null.
std::unique_ptr<Reader> open_reader(std::shared_ptr<FileBlocks> file,
                                    std::shared_ptr<FileBlocks> data, Progress progress = {});

/// The same in a guarded process; null unless start_guarded_reading() was called, and trust_files()
/// was not.
std::unique_ptr<Reader> open_guarded_reader(const std::shared_ptr<FileBlocks>& file,
                                            const std::shared_ptr<FileBlocks>& data,
                                            const Progress& progress);

}  // namespace psivox::vdb
