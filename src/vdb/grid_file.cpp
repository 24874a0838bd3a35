#include "grid_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <ios>
#include <new>
#include <sstream>
#include <utility>

namespace psivox::vdb {
namespace {

/// The type of the metadata for delayed loading. Files of OpenVDB 13 and before have them; later
/// libraries do not know them.
constexpr const char* delayed_load_type = "__delayedload";

/// Programs whose Z axis is up, as the metadata `creator` names them, in lower case.
constexpr std::array<std::pair<const char*, const char*>, 4> z_up_programs{{
    {"blender", "Blender"},
    {"3ds max", "3ds Max"},
    {"3dsmax", "3ds Max"},
    {"unreal", "Unreal Engine"},
}};

/// Metadata that only the caches of Blender's fluids have.
constexpr const char* blender_grid_metadata = "file_base_resolution";

/// Names of grids that only Blender's smoke and fire have, beside `density`.
constexpr std::array<const char*, 3> blender_grids{"shadow", "react", "density_noise"};

/// `written by Blender`, if the metadata `creator` name such a program; else empty.
std::string z_up_creator(const MetadataText& metadata) {
  const auto creator = metadata.find("creator");
  if (creator != metadata.end())
    for (const auto& [name, program] : z_up_programs)
      if (lower_case(creator->second).find(name) != std::string::npos)
        return std::string("written by ") + program;
  return "";
}

std::string read_block(std::istream& stream) {
  const auto begin = stream.tellg();
  skip_string(stream);  // throws before memory is allocated
  std::string bytes(static_cast<std::size_t>(stream.tellg() - begin) - sizeof(std::uint32_t), '\0');
  stream.seekg(begin + std::streamoff(sizeof(std::uint32_t)));
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}

}  // namespace

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

void skip_string(std::istream& stream) {
  std::uint32_t length = 0;
  stream.read(reinterpret_cast<char*>(&length), sizeof length);
  stream.seekg(length, std::ios_base::cur);
}

void check_strings(std::istream& stream, int count) {
  const auto begin = stream.tellg();
  for (; count > 0; --count) skip_string(stream);
  stream.seekg(begin);
}

void read_metadata(openvdb::MetaMap& metadata, std::istream& stream, std::string* delayed_load) {
  std::uint32_t count = 0;
  stream.read(reinterpret_cast<char*>(&count), sizeof count);
  for (; count > 0; --count) {
    const std::string name = read_block(stream), type = read_block(stream);
    std::string value = read_block(stream);
    // its own lengths can claim any memory
    if (type == delayed_load_type) {
      if (delayed_load) *delayed_load = std::move(value);
      continue;
    }
    openvdb::Metadata::Ptr made;
    if (openvdb::Metadata::isRegisteredType(type))
      made = openvdb::Metadata::createMetadata(type);
    else
      made = std::make_shared<openvdb::UnknownMetadata>(type);
    // types of one size read that size, whatever the file's length says
    const auto length = static_cast<std::uint32_t>(value.size());
    std::istringstream own(std::string(reinterpret_cast<const char*>(&length), sizeof length) +
                           value);
    made->read(own);
    if (!own) OPENVDB_THROW(openvdb::IoError, "the metadata '" + name + "' are cut off");
    metadata.insertMeta(name, *made);
  }
}

MetadataText text_of(const openvdb::MetaMap& metadata) {
  MetadataText text;
  for (auto it = metadata.beginMeta(); it != metadata.endMeta(); ++it)
    if (it->second) text[it->first] = it->second->str();
  return text;
}

std::string evidence_of_z_up(const MetadataText& file, const std::vector<std::string>& names,
                             const std::vector<MetadataText>& grids) {
  if (file.contains("creator")) {
    if (std::string program = z_up_creator(file); !program.empty()) return program;
  } else {
    for (const MetadataText& grid : grids)
      if (std::string program = z_up_creator(grid); !program.empty()) return program;
  }
  for (const MetadataText& grid : grids)
    if (grid.contains(blender_grid_metadata)) return "a cache of Blender's fluids";
  if (std::ranges::find(names, "density") == names.end()) return "";
  for (const char* name : blender_grids)
    if (std::ranges::find(names, name) != names.end())
      return std::string("a grid '") + name + "', as Blender names it";
  return "";
}

}  // namespace psivox::vdb
