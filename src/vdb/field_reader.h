#pragma once

#include <memory>
#include <vector>

#include "psivox/vdb.h"
#include "reader.h"

namespace psivox::vdb {

/// Reads a grid that is in memory. It judges the values for each role, as a file's are judged.
class FieldReader final : public Reader {
 public:
  explicit FieldReader(std::shared_ptr<const Field> field) : field_(std::move(field)) {}

  FileFacts facts() override;
  std::vector<GridInfo> info(const std::string& grid, bool values) override;
  GridContent content(const std::string& grid) override;
  Field read(const std::string& grid, const ReadOptions& options) override;

 private:
  void check_name(const std::string& grid) const;  ///< throws Error(input)

  std::shared_ptr<const Field> field_;
};

/// Reads grids of other files.
class GatheredReader final : public Reader {
 public:
  /// Throws Error(usage) if names repeat.
  explicit GatheredReader(std::vector<NamedGrid> grids);

  FileFacts facts() override;
  std::vector<GridInfo> info(const std::string& grid, bool values) override;
  GridContent content(const std::string& grid) override;
  Field read(const std::string& grid, const ReadOptions& options) override;

 private:
  const NamedGrid& find(const std::string& grid) const;  ///< throws Error(input)

  std::vector<NamedGrid> grids_;
};

}  // namespace psivox::vdb
