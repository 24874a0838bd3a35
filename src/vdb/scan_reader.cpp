#include "scan_reader.h"

#include <utility>

#include "field_reader.h"

namespace psivox::vdb {

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
  return std::make_unique<FieldReader>(std::move(source));
}

}  // namespace psivox::vdb
