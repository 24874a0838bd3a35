#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scene/camera_file.h"
#include "scene/transfer_function.h"

namespace psivox {

/// A colour map as ParaView exports it: RGBPoints, ColorSpace, Points (opacity); the user guide
/// describes the conversion. Throws Error(input).
TransferFunction transfer_function_from_paraview(const nlohmann::json& object);

/// ParaView's camera (.pvcc). Throws Error(input) with `source` in its message.
FileCamera camera_from_paraview(const std::string& text, const std::string& source);

std::string paraview_of(const FileCamera& camera);

}  // namespace psivox
