#include <utility>

#include "reader.h"
#include "scan/scan.h"

namespace psivox::vdb {
namespace {

/// Reads a scan's frames as grids: `image`, or `image[0]`, `image[1]`, ... of several; `rgb` of
/// colours.
std::unique_ptr<Reader> scan_reader(std::shared_ptr<const scan::Scan> scan, const std::string& path,
                                    Progress progress) {
  const scan::Header& header = scan->header();
  FieldSource source;
  source.path = path;
  source.type = header.format;
  source.facts.metadata = header.metadata;
  source.facts.z_up = header.z_up;
  if (header.frames > 1) source.facts.metadata["frames"] = std::to_string(header.frames);
  const std::string base = header.colour ? "rgb" : "image";
  for (std::int64_t n = 0; n < header.frames; ++n)
    source.facts.grids.push_back({header.frames == 1 ? base : base + "[" + std::to_string(n) + "]",
                                  base, header.channels, header.value_type(),
                                  header.statistic ? "unknown" : "scan"});
  source.make = [scan = std::move(scan), names = source.facts.grids,
                 progress = std::move(progress)](std::size_t n) {
    return std::make_shared<const Field>(scan->read(std::int64_t(n), names[n].name, progress));
  };
  return field_reader(std::move(source));
}

}  // namespace

std::unique_ptr<Reader> open_reader(std::shared_ptr<FileBlocks> file,
                                    std::shared_ptr<FileBlocks> data, Progress progress) {
  if (std::unique_ptr<scan::Scan> scan = scan::open_scan(file, std::move(data)))
    return scan_reader(std::move(scan), file->path(), std::move(progress));
  return open_in_place(std::move(file), std::move(progress));
}

}  // namespace psivox::vdb
