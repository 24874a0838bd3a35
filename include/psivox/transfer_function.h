#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "psivox/colormap.h"

namespace psivox {

/// One knot: what a value of the density grid means.
struct TransferPoint {
  double value = 0;
  double attenuation = 0;  ///< multiplied by the scene's extinction
  glm::dvec3 color{1};     ///< multiplied by the scene's luminance
  bool operator==(const TransferPoint&) const = default;
};

/// Attenuation and colour of a value: linear between points, constant outside.
class TransferFunction {
 public:
  /// Values not descending, at least one point; two of equal value are a jump, made one float32
  /// step wide. Attenuation and colours not negative, all finite and within float32; values are
  /// stored rounded to float32. Throws Error(input).
  explicit TransferFunction(std::vector<TransferPoint> points, bool has_color = true);

  /// Strictly ascending.
  const std::vector<TransferPoint>& points() const { return points_; }

  /// Whether the points give the luminance too; where they do not, it comes from elsewhere.
  bool has_color() const { return has_color_; }

  TransferPoint at(double value) const;

  /// Index k of the interval [point k, point k + 1) that holds the value: -1 before the first
  /// point, points().size() - 1 from the last one on.
  int interval(double value) const;

  /// Greatest attenuation over [min_value, max_value]: of both ends and the points between.
  double max_attenuation(double min_value, double max_value) const;

  /// The same of each colour channel.
  glm::dvec3 max_color(double min_value, double max_value) const;

  /// Antiderivative of the attenuation over the value, quadratic between points; 0 at the first.
  double attenuation_integral(double value) const;

  bool operator==(const TransferFunction&) const = default;

 private:
  std::vector<TransferPoint> points_;
  std::vector<double> integrals_;  ///< attenuation_integral of the points
  bool has_color_;
};

/// {"points": [{"value": v, "attenuation": t, "color": [r, g, b]}, ...]}, `color` in all points or
/// in none; or a colour map that ParaView exported. Throws Error(input); `source` names the file in
/// its message.
TransferFunction transfer_function_from_json(std::string_view text, std::string_view source);

/// Every number returns from transfer_function_from_json as the same bits.
std::string to_json(const TransferFunction& function);

/// Throws Error(input).
TransferFunction read_transfer_function(const std::filesystem::path& path);

/// The value itself as attenuation (0 where negative), and the map's colours over [range_min,
/// range_max]. Has points at the map's knots and at the ends of the data, 0 included since vacuum
/// has it, so that the attenuation is the value up to data_max. Throws Error(input) where range_min
/// is not below range_max.
TransferFunction colormap_function(Colormap map, double range_min, double range_max,
                                   double data_min, double data_max);

}  // namespace psivox
