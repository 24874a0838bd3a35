#pragma once

#include <string>
#include <string_view>

namespace psivox {

/// RFC 4648, with `=`.
std::string base64(std::string_view bytes);

}  // namespace psivox
