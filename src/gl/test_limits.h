#pragma once

#include <cstdint>

namespace psivox::gl {

/// Limits that tests lower below the driver's, so that small volumes reach them. 0: the driver's.
struct TestLimits {
  int turns_per_pass = 0;           ///< loop turns that a ray may take in one draw
  std::uint64_t buffer_texels = 0;  ///< texels of one texture buffer
};

/// Limits of every GlRenderer of the process. Only tests set them.
inline TestLimits test_limits;

}  // namespace psivox::gl
