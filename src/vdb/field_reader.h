#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "psivox/vdb.h"
#include "reader.h"

namespace psivox::vdb {

/// Grids that are fields, which are in memory or made when they are needed.
struct FieldSource {
  FileFacts facts;
  std::string path;  ///< begins messages; empty: no file
  std::string type;  ///< GridInfo::type of all
  /// The grid of that number in `facts`. Throws Error.
  std::function<std::shared_ptr<const Field>(std::size_t)> make;
};

/// Reads fields as grids. It judges the values for each role, as a file's are judged.
class FieldReader final : public Reader {
 public:
  explicit FieldReader(FieldSource source) : source_(std::move(source)) {}
  /// Of one grid that is in memory.
  explicit FieldReader(const std::shared_ptr<const Field>& field);

  FileFacts facts() override { return source_.facts; }
  std::vector<GridInfo> info(const std::string& grid, bool values) override;
  GridContent content(const std::string& grid) override;
  Field read(const std::string& grid, const ReadOptions& options) override;

 private:
  std::size_t find(const std::string& grid) const;  ///< throws Error(input)
  std::shared_ptr<const Field> field(std::size_t number);
  GridInfo row(std::size_t number, bool values);

  FieldSource source_;
  std::mutex mutex_;  ///< of what follows
  std::shared_ptr<const Field> last_;
  std::size_t last_number_ = 0;
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
