#pragma once

#include <functional>

namespace psivox {

/// Long work calls it with the finished fraction, 0 to 1, from one thread. It may be empty.
using Progress = std::function<void(double fraction)>;

}  // namespace psivox
