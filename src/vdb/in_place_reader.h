#pragma once

#include <openvdb/openvdb.h>

#include <memory>
#include <mutex>
#include <string>

#include "file_blocks.h"
#include "psivox/progress.h"
#include "reader.h"

namespace psivox::vdb {

/// The grid that was read last, as long as somebody holds its field. A scene in an automatic look
/// reads its density for one role and then for another.
class LastGrid {
 public:
  /// The grid, if a field for this role has the same values; else null.
  openvdb::GridBase::Ptr get(const std::string& name, GridRole role) const;

  /// Keeps a grid whose values the field shares. A notice tells that reading has changed them.
  void set(const openvdb::GridBase::Ptr& grid, const Field& field, GridRole role);

 private:
  mutable std::mutex mutex_;
  std::string name_;
  GridRole role_ = GridRole::attenuation;
  std::weak_ptr<openvdb::GridBase> grid_;
};

/// Reads in this process. Each read has a stream of its own, so that reads may run in several
/// threads and a failed one does not affect the others.
class InPlaceReader final : public Reader {
 public:
  explicit InPlaceReader(std::shared_ptr<FileBlocks> file, Progress progress = {});

  FileFacts facts() override;
  std::vector<GridInfo> info(bool values) override;
  GridInfo info(const std::string& grid, bool values) const;
  GridContent content(const std::string& grid) override;
  Field read(const std::string& grid, const ReadOptions& options) override;

 private:
  std::shared_ptr<FileBlocks> file_;  ///< shared with the readers of fields
  Progress progress_;
  LastGrid last_;
};

}  // namespace psivox::vdb
