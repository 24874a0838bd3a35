#include "scan/scan.h"

#include <algorithm>
#include <filesystem>
#include <new>
#include <utility>

#include "base/memory.h"
#include "base/text.h"
#include "field/index_space.h"
#include "scan/streams.h"

namespace psivox::scan {
namespace {

/// Each frame becomes a grid with a name. A small gzip could claim billions of them.
constexpr std::int64_t most_frames = 1 << 16;

/// The fewest bytes that hold what a header claims and what it passes over. A line has one at
/// least.
double least_bytes(const Header& header) {
  const double values = double(header.values), bytes = values * size_of(header.type);
  const double lines = double(header.lines), skip = std::max(0.0, double(header.skip));
  switch (header.encoding) {
    case Encoding::raw:
      return lines + skip + bytes;
    case Encoding::gzip:
      return lines + (skip + bytes) / 1032;  // deflate packs no better (zlib's technical details)
    case Encoding::hex:
      return lines + skip + 2 * bytes;
    case Encoding::text:
      break;
  }
  return lines + skip + 2 * values - 1;
}

constexpr std::int64_t leaf_planes = 8;

}  // namespace

Scan::Scan(Header header, std::shared_ptr<FileBlocks> file, std::shared_ptr<FileBlocks> data)
    : header_(std::move(header)), file_(std::move(header_.detached ? data : file)) {
  const FileBlocks& head = header_.detached ? *file : *file_;
  if (!file_) refuse(head, "its values lie in a file beside it, which is not there");
  if (!has_volume(header_.world_from_index)) refuse(head, "its header gives voxels no volume");
  if (header_.frames > most_frames)
    refuse(head, "has " + std::to_string(header_.frames) + " frames; psivox reads up to " +
                     std::to_string(most_frames));
  const std::int64_t room = file_->size() - header_.begin;
  if (least_bytes(header_) > double(room))
    refuse(*file_, "is cut short: its header claims " + std::to_string(header_.values) +
                       " values, more than " + std::to_string(room) + " bytes can hold");
  if (header_.skip < 0) {
    const std::int64_t bytes = header_.values * size_of(header_.type);
    ByteStream all(*file_, header_.begin, header_.encoding == Encoding::gzip);
    header_.skip = all.pass_over_rest() - bytes;
    if (header_.skip < 0) refuse(*file_, "the file ends too early");
  }
}

Scan::~Scan() = default;

void Scan::start_at(std::size_t stream, std::int64_t value) const {
  if (streams_.size() <= stream) streams_.resize(stream + 1);
  std::unique_ptr<ValueStream>& open = streams_[stream];
  if (!open || open->position() > value) open = std::make_unique<ValueStream>(header_, *file_);
  open->pass_over(value - open->position());
}

Field Scan::read(std::int64_t frame, const std::string& name, const Progress& progress) const {
  const std::lock_guard lock(mutex_);
  const std::int64_t plane = header_.strides[2];
  // Channels that lie one volume after another have a stream each. A volume may be a single plane.
  const bool apart = header_.channels > 1 && header_.channel_stride >= plane;
  // frames within a plane are read together
  const bool interleaved = header_.frame_stride < plane;
  const auto streams = std::size_t(apart ? header_.channels : 1);
  const std::int64_t planes = std::min<std::int64_t>(leaf_planes, header_.shape.z);
  const double bytes = double(planes) * double(plane) * double(streams) * sizeof(float);
  if (const std::uint64_t free = available_memory(); free > 0 && bytes > double(free))
    throw Error(ExitCode::memory,
                subject(file_->path()) + "8 of its slices take more than the memory that is free");
  try {
    DenseField field(name, header_.shape, header_.channels, header_.world_from_index);
    std::vector<float> values(std::size_t(planes * plane) * streams);
    const std::int64_t first = interleaved ? 0 : frame * header_.frame_stride;
    for (std::int64_t z = 0; z < header_.shape.z; z += leaf_planes) {
      const std::int64_t count = std::min(leaf_planes, header_.shape.z - z) * plane;
      for (std::size_t s = 0; s < streams; ++s) {
        start_at(s, first + z * plane + std::int64_t(s) * header_.channel_stride);
        streams_[s]->read(std::span(values).subspan(s * std::size_t(count), std::size_t(count)));
      }
      const float* at = values.data() + (interleaved ? frame * header_.frame_stride : 0);
      field.add(
          {at,
           {header_.strides[0], header_.strides[1], plane, apart ? count : header_.channel_stride}},
          2);
      if (progress) progress(double(z) / header_.shape.z);
    }
    Field made = field.finish();
    made.value_type = header_.value_type();
    for (const std::string& notice : header_.notices)
      made.notices.push_back("grid " + in_quotes(name) + ": psivox " + notice);
    return made;
  } catch (const std::bad_alloc&) {
    streams_.clear();
    throw Error(ExitCode::memory, subject(file_->path()) + "takes more than the memory there is");
  } catch (...) {
    streams_.clear();
    throw;
  }
}

std::string data_path(FileBlocks& header) {
  namespace fs = std::filesystem;
  const FileRun first = header.run(0);
  const std::string_view head(first.bytes.get(), std::size_t(first.size));
  fs::path own(header.path());
  if (is_nifti(head)) {
    const bool first_version = head.size() > 346 && head.substr(344).starts_with("ni1");
    if (!first_version && !head.substr(4).starts_with("ni2")) return {};
    return own.replace_extension(".img").string();
  }
  if (!is_nrrd(head)) return {};
  const std::string name = nrrd_data_file(header);
  if (name.empty()) return {};
  if (name.starts_with("LIST") || name.find('%') != name.npos)
    refuse(header, "its values lie in several files, which psivox does not read together");
  const fs::path path(name);
  if (path.is_absolute() || std::ranges::count(path, fs::path("..")))
    refuse(header, "its values lie in " + in_quotes(name) +
                       "; psivox reads files in the header's folder or below");
  return (own.parent_path() / path).string();
}

std::unique_ptr<Scan> open_scan(std::shared_ptr<FileBlocks> file,
                                std::shared_ptr<FileBlocks> data) {
  const FileRun first = file->run(0);
  std::string head(first.bytes.get(), std::size_t(std::min<std::int64_t>(first.size, 8)));
  const bool packed = head.starts_with("\x1f\x8b");
  try {
    if (packed) {
      ByteStream stream(*file, 0, true);
      head.resize(8);
      head.resize(std::size_t(stream.read(head.data(), 8)));
    }
  } catch (const Error&) {
    return nullptr;  // a damaged gzip of any format
  }
  if (!is_nifti(head) && (packed || !is_nrrd(head))) return nullptr;
  Header header = is_nifti(head) ? read_nifti(*file, packed) : read_nrrd(*file);
  return std::make_unique<Scan>(std::move(header), std::move(file), std::move(data));
}

}  // namespace psivox::scan
