// psivox compare A B: how far two pictures are apart.

#include <cstdio>
#include <iostream>
#include <string>

#include "command_line.h"
#include "commands.h"
#include "psivox/error.h"
#include "psivox/image.h"

namespace psivox {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string per_channel(const std::array<double, 4>& values) {
  std::string out;
  for (std::size_t c = 0; c < 4; ++c)
    out += std::string(c ? "  " : "") + "RGBA"[c] + " " + number(values[c]);
  return out;
}

}  // namespace

void compare_command(Arguments arguments) {
  std::string a, b, max_rms, max_abs;
  CommandLine line("compare",
                   "Prints the difference of two pictures' R G B A, in linear radiance.");
  line.add_positional("A", "an EXR or PNG file", a);
  line.add_positional("B", "another one of the same size", b);
  line.add_value("--max-rms", 0, "X",
                 "exit with 7 where the RMS over pixels and channels is above X", max_rms);
  line.add_value("--max-abs", 0, "X",
                 "exit with 7 where the largest absolute difference is above X", max_abs);
  if (!line.parse(arguments)) return;
  if (a.empty() || b.empty()) throw Error(ExitCode::usage, "two pictures are needed: A B");
  const double rms_limit = max_rms.empty() ? 0 : read_limit("--max-rms", max_rms);
  const double abs_limit = max_abs.empty() ? 0 : read_limit("--max-abs", max_abs);

  const Comparison difference = compare_images(read_image(a), read_image(b));
  std::cout << "rms   " << number(difference.rms) << "  (" << per_channel(difference.channel_rms)
            << ")\nmean  " << per_channel(difference.channel_mean) << "  (A - B)\nmax   "
            << number(difference.max);
  if (difference.max > 0)
    std::cout << "  at pixel (" << difference.max_x << ", " << difference.max_y << "), "
              << difference.max_channel;
  std::cout << '\n';
  if (difference.not_finite) std::cout << "NaN or Inf in " << difference.not_finite << " pixels\n";

  // Negated, so that a NaN is beyond any limit.
  const auto demand = [](bool within, const std::string& what) {
    if (!within) throw Error(ExitCode::verification, what);
  };
  if (max_rms.empty() && max_abs.empty()) return;
  demand(difference.not_finite == 0,
         "the pictures have NaN or Inf in " + std::to_string(difference.not_finite) + " pixels");
  demand(max_rms.empty() || difference.rms <= rms_limit,
         "RMS " + number(difference.rms) + " is above --max-rms " + max_rms);
  demand(max_abs.empty() || difference.max <= abs_limit,
         "the largest difference " + number(difference.max) + " is above --max-abs " + max_abs);
}

}  // namespace psivox
