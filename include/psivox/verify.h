#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "psivox/scene.h"

namespace psivox {

struct VerifyCase {
  std::string name;
  std::string reason;  ///< why the bound is what it is, in a few words
  double error = 0;    ///< largest difference of a channel
  double bound = 0;
  std::uint64_t stuck = 0;  ///< rays that no longer advanced and were ended early
  bool passed() const { return error <= bound && stuck == 0; }  ///< a NaN fails
};

struct VerifyOptions {
  Filter filter = Filter::exact;
  int device = -1;                                    ///< as ContextOptions::device
  std::function<void(const VerifyCase&)> progress{};  ///< called after each case
};

struct VerifyReport {
  std::string renderer;  ///< GL_RENDERER and GL_VERSION
  std::vector<VerifyCase> cases;
  std::size_t failed() const;
  std::uint64_t stuck() const;
};

/// Draws fields made in memory with this machine's GL driver. It compares their pictures with the
/// reference, or with the march in double by the same rule. Throws Error(graphics).
VerifyReport verify(const VerifyOptions& options = {});

/// One line about the bounds that hold for a filter.
std::string verify_note(Filter filter);

}  // namespace psivox
