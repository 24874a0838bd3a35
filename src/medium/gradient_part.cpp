// The part of a transfer function that depends on the gradient.

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.h"
#include "psivox/error.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

constexpr double largest_float = std::numeric_limits<float>::max();

void check(const std::string& what, double number, double min) {
  if (!(std::abs(number) <= largest_float))
    throw Error(ExitCode::input, what + " " + number_text(number) + " is no finite float32");
  if (number < min) throw Error(ExitCode::input, what + " " + number_text(number) + " is negative");
}

/// Position of a number among ascending ones: fraction `t` between two of them, clamped to the
/// ends.
struct Place {
  std::size_t below = 0, above = 0;
  double t = 0;
};
Place place_among(const std::vector<double>& knots, double x) {
  const auto next =
      static_cast<std::size_t>(std::upper_bound(knots.begin(), knots.end(), x) - knots.begin());
  if (next == 0) return {};
  if (next == knots.size()) return {next - 1, next - 1, 0};
  return {next - 1, next, (x - knots[next - 1]) / (knots[next] - knots[next - 1])};
}

/// Fraction of an isosurface's attenuation at a distance [value] from its value.
double share(const Isosurface& surface, double distance, double gradient) {
  const double reach = surface.thickness * gradient;
  if (distance < reach) return 1 - distance / reach;
  return distance == 0 ? 1 : 0;
}

}  // namespace

/// Checks the part, rounds to float32 the numbers that are compared with values of grids, and takes
/// the points' attenuations from the table.
void TransferFunction::place_gradient_part() {
  std::vector<double>& gradients = part_.gradients;
  for (std::size_t j = 0; j < gradients.size(); ++j) {
    check("gradient", gradients[j], 0);
    const double gradient = static_cast<float>(gradients[j]);
    if (j > 0 && !(gradient > gradients[j - 1]))
      throw Error(ExitCode::input, "gradients must ascend, but " + number_text(gradients[j]) +
                                       " follows " + number_text(gradients[j - 1]));
    gradients[j] = gradient;
  }
  if (part_.attenuation.size() != points_.size() * gradients.size())
    throw Error(ExitCode::input,
                "the transfer function needs an attenuation of each point at each gradient");
  for (const double attenuation : part_.attenuation) check("attenuation", attenuation, 0);
  for (std::size_t k = 0; k < points_.size() && !gradients.empty(); ++k) {
    const double* row = part_.attenuation.data() + k * gradients.size();
    points_[k].attenuation = *std::max_element(row, row + gradients.size());
  }
  for (Isosurface& surface : part_.isosurfaces) {
    check("value of an isosurface", surface.value, -largest_float);
    check("attenuation of an isosurface", surface.attenuation, 0);
    check("thickness of an isosurface", surface.thickness, 0);
    if (surface.thickness == 0)
      throw Error(ExitCode::input, "thickness of an isosurface is 0; nothing of it would be seen");
    surface.value = static_cast<double>(static_cast<float>(surface.value)) + 0.0;  // not -0
  }
}

double TransferFunction::table(double value, double gradient) const {
  if (part_.gradients.empty()) return at(value).attenuation;
  const Place column = place_among(part_.gradients, gradient);
  const auto row = [&](std::size_t point) {
    const double* of = part_.attenuation.data() + point * part_.gradients.size();
    return std::lerp(of[column.below], of[column.above], column.t);
  };
  const int k = interval(value);
  const auto below = static_cast<std::size_t>(std::max(k, 0));
  if (k < 0 || below + 1 == points_.size()) return row(below);
  const double a = points_[below].value, b = points_[below + 1].value;
  return std::lerp(row(below), row(below + 1), (value - a) / (b - a));
}

double TransferFunction::attenuation(double value, double gradient) const {
  double sum = table(value, gradient);
  for (const Isosurface& surface : part_.isosurfaces)
    sum += surface.attenuation * share(surface, std::abs(value - surface.value), gradient);
  return sum;
}

double TransferFunction::max_attenuation(const glm::dvec2& values,
                                         const glm::dvec2& gradients) const {
  // A bilinear function is greatest at a corner of its rectangle.
  double most = 0;
  const auto see_row = [&](double value) {
    most = std::max({most, table(value, gradients.x), table(value, gradients.y)});
    for (const double gradient : part_.gradients)
      if (gradient > gradients.x && gradient < gradients.y)
        most = std::max(most, table(value, gradient));
  };
  see_row(values.x);
  see_row(values.y);
  for (int k = interval(values.x) + 1; k <= interval(values.y); ++k)
    see_row(points_[static_cast<std::size_t>(k)].value);
  for (const Isosurface& surface : part_.isosurfaces) {
    const double nearest = std::max({values.x - surface.value, surface.value - values.y, 0.0});
    most += surface.attenuation * share(surface, nearest, gradients.y);
  }
  return most;
}

}  // namespace psivox
