// psivox compare A B: measures the difference of two pictures.

#include <iostream>
#include <optional>
#include <string>

#include "base/input_file.h"
#include "command_line.h"
#include "psivox/image.h"
#include "render_call.h"

namespace psivox {
namespace {

std::string number(double value) { return formatted("%.6g", value); }

std::string per_channel(const std::array<double, 4>& values) {
  std::string out;
  for (std::size_t c = 0; c < 4; ++c)
    out += std::string(c ? "  " : "") + "RGBA"[c] + " " + number(values[c]);
  return out;
}

}  // namespace

void compare_command(Arguments arguments) {
  std::string a, b, diff;
  std::optional<double> max_rms, max_abs;
  CommandLine line(
      "compare", "Prints the difference of two pictures in linear radiance.", {},
      {"a.exr b.exr", "a.exr b.exr --diff difference.png", "a.exr b.exr --max-rms 1e-3"});
  line.add_value("A", a, "", "picture: any that psivox writes")->required();
  line.add_value("B", b, "", "another of the same size")->required();
  line.add_value("--diff", diff, "FILE",
                 "picture of A - B to write: blue where A is darker, red where it is brighter");
  const CLI::Validator limit = number_in<double>({.min = 0});
  line.add_value("--max-rms", max_rms, "X",
                 "exit with 7 if the RMS over pixels and channels exceeds X")
      ->check(limit);
  line.add_value("--max-abs", max_abs, "X",
                 "exit with 7 if the largest absolute difference exceeds X")
      ->check(limit);
  if (!line.read(arguments)) return;

  const WrittenFile written[] = {{"--diff", diff}};
  for (const std::string& read : {a, b}) InputProtection::expect(read);
  check_overwriting(written);
  if (is_standard_output(diff)) usage("--diff needs a file: the numbers have the standard output");
  if (!diff.empty()) check_writable(diff);
  const Image image_a = read_image(a), image_b = read_image(b);
  const Comparison difference = compare_images(image_a, image_b);
  std::cout << "rms   " << number(difference.rms) << "  (" << per_channel(difference.channel_rms)
            << ")\nmean  " << per_channel(difference.channel_mean) << "  (A - B)\nmax   "
            << number(difference.max);
  if (difference.max > 0)
    std::cout << "  at pixel (" << difference.max_x << ", " << difference.max_y << "), "
              << difference.max_channel;
  std::cout << '\n';
  if (!diff.empty()) {
    const double scale = difference_scale(image_a, image_b);
    write_image(difference_picture(image_a, image_b, scale), diff);
    std::cout << "diff  " << in_quotes(diff) << ": full colour from " << number(scale) << " on\n";
  }
  const std::string not_finite = formatted("NaN or Inf in %zu pixel%s", difference.not_finite,
                                           difference.not_finite == 1 ? "" : "s");
  if (difference.not_finite) std::cout << not_finite << '\n';

  // Negated, so that NaN exceeds every limit.
  const auto demand = [](bool within, const std::string& what) {
    if (!within) throw Error(ExitCode::verification, what);
  };
  if (!max_rms && !max_abs) return;
  demand(difference.not_finite == 0, "the pictures have " + not_finite);
  demand(!max_rms || difference.rms <= *max_rms,
         "RMS " + number(difference.rms) + " is above --max-rms " + number_text(*max_rms));
  demand(!max_abs || difference.max <= *max_abs,
         "the largest difference " + number(difference.max) + " is above --max-abs " +
             number_text(*max_abs));
}

}  // namespace psivox
