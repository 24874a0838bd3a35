#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "psivox/scene.h"

namespace psivox {

struct Scene;

/// One knot: attenuation and colour of a value of the density grid.
struct TransferPoint {
  double value = 0;
  double attenuation = 0;  ///< multiplied by the scene's extinction
  glm::dvec3 color{1};     ///< multiplied by the scene's luminance
  bool operator==(const TransferPoint&) const = default;
};

/// The surface of a value f, drawn as a shell. Where the field is linear across the shell, its
/// thickness does not depend on the steepness. M. Levoy, Display of Surfaces from Volume Data,
/// 1988, eq. 3: at a point of value v and gradient magnitude g it adds the attenuation
///   attenuation * max(0, 1 - |v - f| / (thickness g));    where g = 0: all of it at v = f, else 0.
struct Isosurface {
  double value = 0;
  double thickness = 1;    ///< to either side [world units]
  double attenuation = 0;  ///< at the surface; multiplied by the scene's extinction
  bool operator==(const Isosurface&) const = default;
};

/// Makes the attenuation a function of the gradient's magnitude too (G. Kindlmann and J. Durkin,
/// Semi-Automatic Generation of Transfer Functions, 1998).
struct GradientPart {
  /// Gradients of the table's columns [value/world unit]. Empty: the points' attenuations hold for
  /// every gradient.
  std::vector<double> gradients{};
  /// Attenuation of point k at gradient j, at index k * gradients.size() + j. It is bilinear in
  /// value and gradient, and constant beyond the first and the last gradient.
  std::vector<double> attenuation{};
  std::vector<Isosurface> isosurfaces{};  ///< their attenuation adds to the table's
  bool operator==(const GradientPart&) const = default;
};

/// Attenuation and colour of a value: linear between points, constant outside. With a GradientPart
/// the attenuation depends on value and gradient, the colour on the value alone.
class TransferFunction {
 public:
  /// Needs at least one point; values must not descend. Two points of equal value are a jump, which
  /// becomes one float32 step wide. Attenuations and colours must not be negative; all numbers must
  /// be finite and within float32. Values are stored rounded to float32. Gradients must ascend and
  /// not be negative; thicknesses must be above 0. With a table, each point's attenuation becomes
  /// its greatest at any gradient. Throws Error(input).
  explicit TransferFunction(std::vector<TransferPoint> points, bool has_color = true,
                            GradientPart gradient_part = {});

  /// Strictly ascending.
  const std::vector<TransferPoint>& points() const { return points_; }

  /// Whether the points give the luminance too; if not, it comes from elsewhere.
  bool has_color() const { return has_color_; }

  /// With a table, the attenuation is no less than at any gradient. Isosurfaces are left out.
  TransferPoint at(double value) const;
  /// at() without the colour, which takes most of its time.
  double attenuation(double value) const;

  /// Whether the attenuation depends on the gradient.
  bool has_gradient() const { return !part_.gradients.empty() || !part_.isosurfaces.empty(); }
  const GradientPart& gradient_part() const { return part_; }

  /// Attenuation at a gradient magnitude [value/world unit], which matters only if has_gradient().
  double attenuation(double value, double gradient) const;

  /// Upper bound of attenuation() over ranges (min, max) of values and gradients; max may be
  /// infinite. It is 0 only if attenuation() is.
  double max_attenuation(const glm::dvec2& values, const glm::dvec2& gradients) const;

  /// The function without its colours: points in which the attenuation does not bend, to float32,
  /// are left out.
  TransferFunction attenuation_alone() const;

  /// Index k of the interval [point k, point k + 1) that holds the value: -1 before the first
  /// point, points().size() - 1 from the last one on.
  int interval(double value) const;

  /// Greatest attenuation over [min_value, max_value]: at both ends or at a point between.
  double max_attenuation(double min_value, double max_value) const;

  /// Greatest of each colour channel over [min_value, max_value].
  glm::dvec3 max_color(double min_value, double max_value) const;

  bool operator==(const TransferFunction&) const = default;

 private:
  void place_gradient_part();
  double table(double value, double gradient) const;

  std::vector<TransferPoint> points_;
  bool has_color_;
  GradientPart part_;
};

/// {"points": [{"value": v, "attenuation": t, "color": [r, g, b]}, ...]}, `color` in all points or
/// in none. Optional: "gradients": [g, ...], with which an attenuation may be an array of as many;
/// and "isosurfaces": [{"value": v, "thickness": r, "attenuation": t}, ...], without or beside
/// points. It also reads a colour map that ParaView exported. Throws Error(input); `source` names
/// the file in its message.
TransferFunction transfer_function_from_json(std::string_view text, std::string_view source);

/// A colour map as ParaView exports it: RGBPoints, ColorSpace, Points (opacity); the user guide
/// describes the conversion. Throws Error(input).
TransferFunction transfer_function_from_paraview(const nlohmann::json& object);

/// Every number returns from transfer_function_from_json as the same bits.
std::string to_json(const TransferFunction& function);

/// Throws Error(input).
TransferFunction read_transfer_function(const std::filesystem::path& path);

/// The function of values that have passed a scale: its points' values pass it too, and it is
/// linear between them there. Of points that a log scale makes 0 the last one stays.
TransferFunction scaled_function(const TransferFunction& function, const ValueScale& scale);

/// The function of a scene that windows its values: u is 0 and 1 at the ends of `range`.
///
/// | | attenuation | colour |
/// |---|---|---|
/// | --opacity | the curve of u | |
/// | a symlog scale, but of maxima | the magnitude of the value | |
/// | a colour map | the value, at least 0; of maxima u, at least 0 | the map of u |
/// | maxima | u, at least 0 | the same: a value beyond the range is brighter than 1 |
/// | else | u within 0 and 1 | |
///
/// The first row that applies gives each. `stored` is the range of the grid's values, with 0.
TransferFunction window_function(const Scene& scene, const glm::dvec2& range,
                                 const glm::dvec2& stored);

}  // namespace psivox
