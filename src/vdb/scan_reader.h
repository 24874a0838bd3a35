#pragma once

#include <memory>

#include "psivox/progress.h"
#include "scan/scan.h"
#include "vdb/reader.h"

namespace psivox::vdb {

/// Reads a scan's frames as grids: `image`, or `image[0]`, `image[1]`, ... of several; `rgb` of
/// colours.
std::unique_ptr<Reader> scan_reader(std::shared_ptr<const scan::Scan> scan, const std::string& path,
                                    Progress progress);

}  // namespace psivox::vdb
