#pragma once

#include <string>

#include "psivox/camera_file.h"

namespace psivox {

/// ParaView's camera (.pvcc). Throws Error(input) with `source` in its message.
FileCamera camera_from_paraview(const std::string& text, const std::string& source);

std::string paraview_of(const FileCamera& camera);

}  // namespace psivox
