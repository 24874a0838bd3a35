#pragma once

#include <nlohmann/json_fwd.hpp>

#include "scene/transfer_function.h"

namespace psivox {

/// A colour map as ParaView exports it: RGBPoints, ColorSpace, Points (opacity); the user guide
/// describes the conversion. Throws Error(input).
TransferFunction transfer_function_from_paraview(const nlohmann::json& object);

}  // namespace psivox
