#include "in_place_reader.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "archive.h"
#include "conform.h"
#include "grid_content.h"
#include "grid_info.h"
#include "grid_types.h"
#include "read_grid.h"
#include "stored_grid.h"
#include "subject.h"

namespace psivox::vdb {

openvdb::GridBase::Ptr LastGrid::get(const std::string& name, GridRole role) const {
  const std::lock_guard lock(mutex_);
  if (name != name_ || (role_ == GridRole::data && role != GridRole::data)) return nullptr;
  return grid_.lock();
}

void LastGrid::set(const openvdb::GridBase::Ptr& grid, const Field& field, GridRole role) {
  const std::lock_guard lock(mutex_);
  name_ = field.name;
  role_ = role;
  grid_.reset();
  if (field.notices.empty()) grid_ = grid;
}

InPlaceReader::InPlaceReader(std::shared_ptr<FileBlocks> file, Progress progress)
    : file_(std::move(file)), progress_(std::move(progress)) {}

FileFacts InPlaceReader::facts() {
  Archive archive(*file_, progress_);
  FileFacts facts;
  facts.metadata = archive.metadata();
  std::vector<MetadataText> grids;
  for (const GridEntry& entry : archive.entries()) {
    facts.names.push_back(entry.name);
    facts.base_names.push_back(entry.descriptor.gridName());
    facts.channels.push_back(entry.problem.empty() ? channels_of(entry.descriptor.gridType()) : 0);
    facts.value_types.push_back(value_type_of(entry.descriptor.gridType()));
    grids.push_back(archive.metadata_of(entry));
    const auto grid_class = grids.back().find("class");
    facts.classes.push_back(grid_class == grids.back().end() ? "unknown" : grid_class->second);
  }
  facts.z_up = evidence_of_z_up(facts.metadata, facts.base_names, grids);
  return facts;
}

std::vector<GridInfo> InPlaceReader::info(bool values) {
  Archive archive(*file_);
  std::vector<GridInfo> rows;
  for (const GridEntry& entry : archive.entries())
    rows.push_back(grid_info(archive, entry, values));
  return rows;
}

GridInfo InPlaceReader::info(const std::string& grid, bool values) const {
  Archive archive(*file_);
  return grid_info(archive, archive.find(grid), values);
}

GridContent InPlaceReader::content(const std::string& grid) {
  Archive archive(*file_);
  return content_of(archive, archive.find(grid), file_);
}

Field InPlaceReader::read(const std::string& grid, const ReadOptions& options) {
  Archive archive(*file_, progress_);
  const GridEntry& entry = archive.find(grid);
  openvdb::GridBase::Ptr values;
  if (!options.active) values = last_.get(entry.name, options.role);
  std::optional<Field> stored;
  if (!values) stored = stored_field(archive, entry, file_, options);
  if (!values && !stored)
    values = options.active ? activity_of(archive.read_topology(entry)) : archive.read(entry);
  const std::string name = entry.name + (options.active ? ":active" : "");
  Field field = stored
                    ? std::move(*stored)
                    : field_from_grid(values, name, subject(archive.path(), entry.name), options);
  if (!options.active) field.value_type = value_type_of(entry.descriptor.gridType());
  if (!stored && !options.active) last_.set(values, field, options.role);
  if (entry.name != grid && !grid.empty()) {
    const auto same = std::ranges::count(archive.entries(), grid, [](const GridEntry& other) {
      return other.descriptor.gridName();
    });
    field.notices.insert(field.notices.begin(), "grid '" + grid + "': " + std::to_string(same) +
                                                    " grids have this name; took '" + entry.name +
                                                    "'");
  }
  return field;
}

}  // namespace psivox::vdb
