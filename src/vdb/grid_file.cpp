#include "grid_file.h"

#include <algorithm>
#include <ios>
#include <map>
#include <new>
#include <utility>

#include "base/text.h"
#include "psivox/error.h"

namespace psivox::vdb {

std::string explain(const std::exception& e) {
  if (dynamic_cast<const std::ios_base::failure*>(&e)) return "the file ends too early";
  if (dynamic_cast<const std::bad_alloc*>(&e)) return "it asks for more memory than there is";
  std::string text = e.what();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return printable(text);
}

GridFile::GridFile(std::shared_ptr<FileBlocks> file, Progress progress)
    : file_(std::move(file)), buffer_(*file_, std::move(progress)) {
  stream_.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
}

/// OpenVDB's names, `density` or `density[1]`, with control characters escaped. It writes grids
/// without a name as `[0]`, `[1]`; where another program repeats a name without numbers, they are
/// numbered here.
void GridFile::name_entries() {
  std::map<std::string, int> uses;
  for (GridEntry& entry : entries_) {
    entry.name =
        printable(openvdb::io::GridDescriptor::nameAsString(entry.descriptor.uniqueName()));
    ++uses[entry.name];
  }
  std::map<std::string, int> next;
  for (GridEntry& entry : entries_) {
    const std::string name = entry.name;
    if (name.empty() || uses[name] > 1) entry.name += "[" + std::to_string(next[name]++) + "]";
  }
}

const GridEntry& GridFile::find(std::string_view name) const {
  for (const GridEntry& entry : entries_) {
    if (entry.name == name) return entry;
  }
  for (const GridEntry& entry : entries_) {
    if (entry.descriptor.gridName() == name) return entry;
  }
  std::vector<std::string> names;
  for (const GridEntry& entry : entries_) names.push_back(entry.name);
  std::string message = subject(path()) + "has no grid " + in_quotes(name) + "; it has";
  for (const std::string& known : nearest_first(name, names)) message += " " + in_quotes(known);
  if (names.empty()) message += " none";
  throw Error(ExitCode::input, message);
}

void GridFile::guarded(const GridEntry& entry, const std::function<void()>& work) const {
  if (!entry.problem.empty())
    throw Error(ExitCode::input, subject(path(), entry.name) + entry.problem);
  try {
    work();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw Error(ExitCode::input, subject(path(), entry.name) + "cannot be read: " + explain(e));
  }
}

}  // namespace psivox::vdb
