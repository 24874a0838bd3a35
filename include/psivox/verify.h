#pragma once

#include <functional>
#include <string>
#include <vector>

#include "psivox/scene.h"

namespace psivox {

/// What one case of verify found.
struct VerifyCase {
  std::string name;
  std::string reason;  ///< why the bound is what it is, in a few words
  double error = 0;    ///< largest over the case's pictures; +Inf for one that shows nothing
  double bound = 0;
  bool passed() const { return error <= bound; }  ///< a NaN fails
};

struct VerifyOptions {
  Filter filter = Filter::exact;
  int device = -1;                                    ///< as ContextOptions::device
  std::function<void(const VerifyCase&)> progress{};  ///< called after each case
};

struct VerifyReport {
  std::string renderer;  ///< GL_RENDERER and GL_VERSION
  std::vector<VerifyCase> cases;
  std::vector<std::string> left_out;  ///< names of cases of which the filter says nothing
  std::size_t failed() const;
};

/// Draws fields made in memory, whose pictures are known, through this machine's GL driver, and
/// compares: with closed forms in double, or one picture with another that has to be the same.
/// Throws Error(graphics).
VerifyReport verify(const VerifyOptions& options = {});

/// One line that says what bounds hold for a filter.
std::string verify_note(Filter filter);

}  // namespace psivox
