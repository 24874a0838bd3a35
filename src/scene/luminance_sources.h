#pragma once

#include "psivox/medium.h"

namespace psivox {

/// Sets where the medium's luminance comes from under the scene's mode, and the light that is still
/// to be computed. `function` is that of the density's values, or null; the medium has its density
/// and transfer already. Throws Error(input).
void set_luminance(const Scene& scene, const MediumFields& fields,
                   const std::shared_ptr<const TransferFunction>& function, Medium& medium);

}  // namespace psivox
