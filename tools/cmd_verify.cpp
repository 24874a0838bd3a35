// psivox verify: checks that this machine's GL driver draws pictures with known results correctly.

#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "command_line.h"
#include "psivox/verify.h"

namespace psivox {
namespace {

using Json = nlohmann::ordered_json;

void print_case(const VerifyCase& c) {
  std::cout << formatted("%-30s %-8.1e %-8.1e %s  ", c.name.c_str(), c.error, c.bound,
                         c.passed() ? "pass" : "FAIL")
            << c.reason << std::endl;
}

std::string summary(const VerifyReport& report, double seconds) {
  const std::string time = formatted(" (%.1f s)", seconds);
  const std::string all = std::to_string(report.cases.size()) + " cases";
  const std::size_t failed = report.failed();
  return (failed ? std::to_string(failed) + " of " + all + " failed" : all + ", all passed") + time;
}

void print_json(const VerifyReport& report, Filter filter, double seconds) {
  Json cases = Json::array();
  for (const VerifyCase& c : report.cases)
    cases.push_back({{"name", c.name},
                     {"error", c.error},
                     {"bound", c.bound},
                     {"reason", c.reason},
                     {"stuck", c.stuck},
                     {"passed", c.passed()}});
  const Json out = {{"version", PSIVOX_VERSION},
                    {"renderer", report.renderer},
                    {"filter", filter == Filter::hardware ? "hardware" : "exact"},
                    {"note", verify_note(filter)},
                    {"cases", cases},
                    {"failed", report.failed()},
                    {"passed", report.failed() == 0},
                    {"seconds", seconds}};
  std::cout << out.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
}

}  // namespace

void verify_command(Arguments arguments) {
  bool as_json = false;
  std::vector<Setting> settings;
  CommandLine line(
      "verify",
      "Checks this machine's GL driver: draws cases whose results are known. Exits with "
      "7 if one misses its bound, with 4 if rays stand still.",
      {}, {"", "--device 1", "--filter hardware --json"});
  line.add_flag("--json", as_json, "print JSON");
  line.add_parameters(settings,
                      [](const Parameter& p) { return p.name == "filter" || p.name == "device"; });
  if (!line.read(arguments)) return;
  Scene scene;
  apply_over(scene, settings);

  if (!as_json)
    std::cout << verify_note(scene.filter) << '\n'
              << formatted("%-30s %-8s %-8s ", "case", "error", "bound")
              << "      reason for the bound" << std::endl;
  const Stopwatch watch;
  VerifyOptions options{.filter = scene.filter, .device = scene.device};
  if (!as_json) options.progress = print_case;
  const VerifyReport report = verify(options);
  const double seconds = 1e-3 * watch.ms();

  if (as_json) {
    print_json(report, scene.filter, seconds);
  } else {
    std::cout << summary(report, seconds) << "; " << report.renderer << '\n';
  }
  if (report.failed() == 0) return;
  std::string names;
  for (const VerifyCase& c : report.cases)
    if (!c.passed()) names += (names.empty() ? "" : "; ") + c.name;
  if (report.stuck() > 0)
    throw Error(ExitCode::graphics, std::to_string(report.stuck()) +
                                        " rays stood still before their end, in pictures of: " +
                                        names + "; use another --device or driver");
  throw Error(ExitCode::verification, "cases beyond their bounds: " + names);
}

}  // namespace psivox
