#pragma once

#include <functional>

namespace psivox {

/// Called by long work with the done fraction, 0 to 1, from one thread. Empty: nobody listens.
using Progress = std::function<void(double fraction)>;

}  // namespace psivox
