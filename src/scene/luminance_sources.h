#pragma once

#include "psivox/medium.h"

namespace psivox {

/// Sets the source of the medium's luminance under the scene's mode, and the light that is still to
/// be computed. `function` maps the density's values, or is null. The medium must have its density
/// and transfer already. Throws Error(input).
void set_luminance(const Scene& scene, const MediumFields& fields,
                   const std::shared_ptr<const TransferFunction>& function, Medium& medium);

}  // namespace psivox
