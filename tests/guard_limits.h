#pragma once

#include "guard/service.h"

namespace psivox::test {

/// Sets limits for one test.
class Limits {
 public:
  explicit Limits(const guard::Limits& limits) { guard::limits = limits; }
  ~Limits() { guard::limits = {}; }
};

}  // namespace psivox::test
