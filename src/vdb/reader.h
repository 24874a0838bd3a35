#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/file_blocks.h"
#include "base/text.h"
#include "psivox/error.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

/// What a file tells of a grid that has not been read.
struct GridFacts {
  std::string name;       ///< as --grid takes it; no other grid of the file has it
  std::string base_name;  ///< as the file has it: names may repeat
  int channels = 0;       ///< 0 if the grid cannot be read
  std::string value_type, grid_class;
  GridPlace place{};
};

/// What a file tells without its grids being read.
struct FileFacts {
  std::vector<GridFacts> grids;  ///< in file order
  std::map<std::string, std::string> metadata{};
  std::string z_up{};
  int lost = 0;                   ///< number of its grids that are cut off or damaged
  std::uint64_t value_bytes = 0;  ///< of all values, unpacked, if the header tells
};

/// Leaves of a field whose values have stayed in the file.
struct LeavesWish {
  std::string grid;
  ReadOptions options{};  ///< by which the field was read
  float largest = 0;      ///< in place of +Inf
  std::vector<std::uint32_t> numbers{};
};

/// Whether the values of a field's leaves have stayed there.
inline bool stays_in_file(const Field& field) {
  return !field.leaves.empty() && !field.leaves.front().values && !field.array;
}

/// What VolumeFile does with an open file; VolumeFile documents the functions. They take grids by
/// GridFacts::name. Several threads may call them.
class Reader {
 public:
  Reader() = default;
  virtual ~Reader() = default;
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  virtual FileFacts facts() = 0;
  virtual GridInfo info(const std::string& grid, bool values) = 0;
  virtual GridContent content(const std::string& grid) = 0;
  /// If the values of leaves stay in the file, the leaves have none, and `leaves` reads them.
  virtual Field read(const std::string& grid, const ReadOptions& options) = 0;
  /// Values of some leaves, one leaf after another. Throws std::logic_error if they do not stay in
  /// a file.
  virtual std::vector<float> leaves(const LeavesWish&) { throw std::logic_error("a whole field"); }
};

/// The item of a reader's list that has this name. Throws Error(input), if the file has changed.
template <typename Item>
const Item& named(const std::vector<Item>& items, const std::string& name,
                  const std::string& path) {
  const auto found = std::ranges::find(items, name, &Item::name);
  if (found == items.end())
    throw Error(ExitCode::input, subject(path) + "has no grid " + in_quotes(name));
  return *found;
}

/// Does work. If that throws an exception e that is no Error, throws Error(input) with text(e).
template <typename Work, typename Text>
auto or_input_error(const Work& work, const Text& text) {
  try {
    return work();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw Error(ExitCode::input, text(e));
  }
}

/// The reader of a file's format, by the file's first bytes, in this process. `data`: the file of
/// values that the file says lie beside it (scan::data_path), or null.
std::unique_ptr<Reader> open_reader(std::shared_ptr<FileBlocks> file,
                                    std::shared_ptr<FileBlocks> data, Progress progress = {});

/// The same in a guarded process; null unless start_guarded_reading() was called, and files are not
/// trusted. Throws Error(input) if Trust::no demands such a process.
std::unique_ptr<Reader> open_guarded_reader(std::shared_ptr<FileBlocks> file,
                                            std::shared_ptr<FileBlocks> data,
                                            Progress progress = {});

/// Grids that are fields, which are in memory or made when they are needed.
struct FieldSource {
  FileFacts facts;
  std::string path{};  ///< begins messages; empty: no file
  std::string type{};  ///< GridInfo::type of all
  /// The grid of that number in `facts`. Throws Error.
  std::function<std::shared_ptr<const Field>(std::size_t)> make;
};

/// Reads fields as grids, and judges their values for each role as a file's are judged.
std::unique_ptr<Reader> field_reader(FieldSource source);
/// Reads grids of other files. Throws Error(usage) if names repeat.
std::unique_ptr<Reader> gathered_reader(std::vector<NamedGrid> grids);

}  // namespace psivox::vdb
