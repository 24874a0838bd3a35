#include "psivox/verify.h"

#include <algorithm>

#include "verify/case.h"

namespace psivox {

std::size_t VerifyReport::failed() const {
  return std::size_t(
      std::count_if(cases.begin(), cases.end(), [](const VerifyCase& c) { return !c.passed(); }));
}

std::uint64_t VerifyReport::stuck() const {
  std::uint64_t sum = 0;
  for (const VerifyCase& c : cases) sum += c.stuck;
  return sum;
}

VerifyReport verify(const VerifyOptions& options) {
  const std::shared_ptr<Marcher> gpu = open_gpu({.device = options.device});
  const Painter painter(*gpu, options.filter);
  VerifyReport report;
  report.renderer = description(*gpu);
  for (const auto& group : {opacity_cases(), radiance_cases(), source_cases(), invariance_cases()})
    for (const Case& c : group) {
      if (options.filter == Filter::hardware && !c.hardware) {
        report.left_out.push_back(c.name);
        continue;
      }
      report.cases.push_back(run_case(c, painter));
      if (options.progress) options.progress(report.cases.back());
    }
  return report;
}

std::string verify_note(Filter filter) {
  if (filter == Filter::exact) return "filter exact: trilinear weights in float32";
  return "filter hardware: bounds are wider by 2^-8 of what a weight changes, since devices may "
         "round trilinear weights to 8 bits";
}

}  // namespace psivox
