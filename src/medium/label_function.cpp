#include "medium/label_function.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "base/text.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "psivox/error.h"

namespace psivox {
namespace {

/// A sum that gives up on too many values.
struct Counting {
  LabelCounts counts;
  bool labels = true;

  void add(float value, std::uint64_t voxels, std::size_t most) {
    if (!labels || !is_active(value)) return;
    counts[value] += voxels;
    labels = counts.size() <= most;
  }
};

/// Linear light of OKLCh (B. Ottosson 2020), clipped to the gamut of Rec. 709.
glm::dvec3 light_of_oklch(double lightness, double chroma, double hue) {
  const double a = chroma * std::cos(hue), b = chroma * std::sin(hue);
  const glm::dvec3 roots(lightness + 0.3963377774 * a + 0.2158037573 * b,
                         lightness - 0.1055613458 * a - 0.0638541728 * b,
                         lightness - 0.0894841775 * a - 1.2914855480 * b);
  const glm::dvec3 lms = roots * roots * roots;
  const glm::dmat3 rgb_from_lms({4.0767416621, -1.2684380046, -0.0041960863},
                                {-3.3077115913, 2.6097574011, -0.7034186147},
                                {0.2309699292, -0.3413193965, 1.7076147010});
  return glm::clamp(rgb_from_lms * lms, 0.0, 1.0);
}

/// Between two labels, which float32 tells apart.
double between(float a, float b) { return 0.5 * (double(a) + double(b)); }

LabelCounts checked_counts(const Field& field) {
  if (const auto counts = label_counts(field); counts && !counts->empty()) return *counts;
  throw Error(ExitCode::input,
              "grid " + in_quotes(field.name) +
                  " has no labels: --colormap labels needs values other than 0, at "
                  "most 65536 different ones");
}

std::uint64_t most_voxels(const LabelCounts& counts) {
  std::uint64_t most = 1;
  for (const auto& [label, voxels] : counts) most = std::max(most, voxels);
  return most;
}

}  // namespace

std::optional<LabelCounts> label_counts(const Field& field, std::size_t most) {
  check_in_memory(field);
  Counting all = fold_leaves(
      field, Counting(),
      [&](Counting& own, const Leaf&, const OrderedValues& values) {
        for (std::size_t i = 0; i < values.size() && own.labels;) {  // labels fill runs of voxels
          std::size_t end = i + 1;
          while (end < values.size() && values[end] == values[i]) ++end;
          own.add(values[i], end - i, most);
          i = end;
        }
      },
      [&](Counting a, const Counting& b) {
        a.labels = a.labels && b.labels;
        for (const auto& [label, voxels] : b.counts) a.add(label, voxels, most);
        return a;
      });
  for (const Tile& tile : field.tiles) all.add(tile.value.x, tile_voxels(tile), most);
  if (!all.labels) return {};
  return std::move(all.counts);
}

glm::dvec3 label_color(double label) {
  if (label == 0) return glm::dvec3(0);
  constexpr double turn = 2 * 3.141592653589793, golden = 0.6180339887498949;
  constexpr double lightness[] = {0.72, 0.62, 0.82};
  const double part = label * golden;
  return light_of_oklch(lightness[std::size_t(std::fmod(std::abs(label), 3))], 0.14,
                        turn * (part - std::floor(part) + 0.08));
}

std::vector<LabelColor> label_colors(const Field& field) {
  const LabelCounts counts = checked_counts(field);
  const bool whole = std::ranges::all_of(
      counts, [](const auto& label) { return label.first == std::floor(label.first); });
  const glm::dvec3 bone(0.8, 0.75, 0.66);
  std::vector<LabelColor> colors;
  for (const auto& [label, voxels] : counts) {
    // labels that were divided by the greatest are told by their rank
    const double number = whole ? double(label) : double(colors.size() + 1);
    if (label != 0)
      colors.push_back({label, voxels, counts.size() == 1 ? bone : label_color(number)});
  }
  return colors;
}

TransferFunction label_function(const Field& field) {
  std::vector<LabelColor> labels = label_colors(field);
  std::uint64_t largest = 1;
  for (const LabelColor& label : labels) largest = std::max(largest, label.voxels);
  labels.insert(std::ranges::lower_bound(labels, 0.0f, {}, &LabelColor::value),
                {0, 0, glm::dvec3(0)});
  constexpr double most = 64;  // of attenuation: a label of a few voxels
  const auto shown = [&](const LabelColor& label, double value) {
    const double attenuation =
        label.voxels ? std::min(most, std::cbrt(double(largest) / double(label.voxels))) : 0;
    return TransferPoint{value, attenuation, label.color};
  };
  std::vector<TransferPoint> points;
  for (std::size_t i = 1; i < labels.size(); ++i) {
    const double jump = between(labels[i - 1].value, labels[i].value);
    points.push_back(shown(labels[i - 1], jump));
    points.push_back(shown(labels[i], jump));
  }
  return TransferFunction(std::move(points));
}

double label_extinction(const Field& field) {
  constexpr double depth = 2;
  const double voxel = std::abs(glm::determinant(glm::dmat3(field.world_from_index)));
  return depth / std::cbrt(double(most_voxels(checked_counts(field))) * voxel);
}

}  // namespace psivox
