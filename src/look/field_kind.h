#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "psivox/field.h"

namespace psivox {

struct SampledVoxel {
  glm::ivec3 voxel;
  float value;  ///< first channel; not 0
};

/// About `wanted` of the voxels in the box of active ones whose values are not 0, spread evenly, in
/// a fixed order. The same values give the same sample, whether tiles or leaves hold them and
/// wherever leaves begin.
std::vector<SampledVoxel> sample_voxels(const Field& field, std::size_t wanted);

/// What the values of a density are, by a sample of its voxels and by its border. Each is found
/// when it is asked for first.
class FieldKind {
 public:
  explicit FieldKind(std::shared_ptr<const Field> density)
      : kept_(std::move(density)), density_(*kept_) {}

  const std::shared_ptr<const Field>& density() const { return kept_; }

  /// 16,384 voxels or so, as sample_voxels gives them.
  const std::vector<SampledVoxel>& sample();

  /// Whether the values look like those of a scan or a simulation: whole steps of their greatest
  /// one, at most 255 of them. In a grid that is not known to be a fog, integers and values that do
  /// not fade to 0 tell so too; in one that is full up to its faces, more than a few values.
  bool is_scan(bool known_fog, bool full);

  /// Whether most values are low, like those of vessels or plumes in their surroundings: their mean
  /// is in the lowest quarter of the range.
  bool is_mostly_low();

  /// Whether low values are a veil around the others: most of the box is the outside alone. Where
  /// they fill it they are noise.
  bool is_veiled();

  /// Whether values of both signs matter: the lower ones reach a twentieth of the greatest
  /// magnitude.
  bool is_signed() const;

  /// Whether the values are signed distances in any unit of the world or in voxels, whatever the
  /// grid's class says: most of their gradients are equally long (the eikonal equation), and these
  /// do not point in one direction as those of a ramp do. Distances that are cut off at a greatest
  /// one are distances, too.
  bool is_distance();

  /// Whether most values on the faces of the active box are below 0.
  bool is_negative_outside() const;

  /// Whether the values are labels: few different ones, which fill bodies of voxels and do not pass
  /// from one to the next. They are of a type of whole numbers, two or more whole numbers in
  /// floats, or 16 to 255 whole steps of the greatest. What surrounds the object alike tells
  /// nothing.
  bool is_labels();

  /// The value that fills the volume around the object: that of most voxels of the active box's
  /// faces. Else their median, if nine of ten are higher than half of the volume, or if they are
  /// nearly alike and half of the volume is as they are. Unset: there is none.
  std::optional<double> outside();

  /// The label that fills the volume around all others: that of nine of ten voxels of the active
  /// box's faces. Unset: these are no labels, or none does.
  std::optional<double> label_outside();

  /// Whether the outside is 0 to a fiftieth of the greatest magnitude. Where there is none: whether
  /// the values lie about 0, by their median and the ends of 98 % of them.
  bool is_about_0();

  /// Whether the rays of a field that has an outside soon reach values that stay: it is a body, not
  /// a gas.
  bool is_body();

 private:
  /// Those of the sample, ascending.
  const std::vector<float>& values();
  std::vector<float> distinct_values();
  bool find_labels();
  std::optional<double> find_outside();

  std::shared_ptr<const Field> kept_;
  const Field& density_;
  std::optional<std::vector<SampledVoxel>> sample_;
  std::optional<std::vector<float>> values_;
  std::optional<bool> labels_;
  std::optional<std::optional<double>> outside_;
};

}  // namespace psivox
