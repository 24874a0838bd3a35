#pragma once

#include <memory>
#include <vector>

#include "psivox/vdb.h"
#include "reader.h"

namespace psivox::vdb {

/// Reads a grid that is in memory: checks its values for each role, as those of a file.
class FieldReader final : public Reader {
 public:
  explicit FieldReader(std::shared_ptr<const Field> field) : field_(std::move(field)) {}

  FileFacts facts() override;
  std::vector<GridInfo> info(bool values) override;
  Field read(const std::string& grid, const ReadOptions& options) override;

 private:
  std::shared_ptr<const Field> field_;
};

/// Reads grids of other files.
class GatheredReader final : public Reader {
 public:
  /// Throws Error(usage) if names repeat.
  explicit GatheredReader(std::vector<NamedGrid> grids);

  FileFacts facts() override;
  std::vector<GridInfo> info(bool values) override;
  Field read(const std::string& grid, const ReadOptions& options) override;

 private:
  std::vector<NamedGrid> grids_;
};

}  // namespace psivox::vdb
