#pragma once

#include <map>
#include <string>

namespace psivox {

/// Files of assets/looks by name: `smoke.json`.
const std::map<std::string, std::string>& embedded_looks();

}  // namespace psivox
