#include "march/light.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <optional>

#include "scene/field_index.h"

namespace psivox {
namespace {

/// Blocks whose depths are asked for at once, between two reports of progress.
constexpr std::size_t batch = 512;

/// The luminance of the medium before its light and without `color`, at voxels of the density.
class OwnLuminance {
 public:
  explicit OwnLuminance(const Medium& medium) : medium_(medium) {
    if (medium.transfer || medium.source == LuminanceSource::density)
      index_.emplace(*medium.density);
    if (medium.luminance) {
      index_.emplace(*medium.luminance);
      to_luminance_ =
          glm::inverse(medium.luminance->world_from_index) * medium.density->world_from_index;
    }
  }

  glm::dvec3 at(const glm::ivec3& voxel) const {
    switch (medium_.source) {
      case LuminanceSource::constant:
        break;
      case LuminanceSource::density:
        return glm::dvec3(index_->at(voxel).x);
      case LuminanceSource::transfer:
        return medium_.transfer->at(index_->at(voxel).x).color;
      case LuminanceSource::scalar:
        return glm::dvec3(other(voxel).x);
      case LuminanceSource::vector:
        return other(voxel);
    }
    return glm::dvec3(1);
  }

 private:
  glm::dvec3 other(const glm::ivec3& voxel) const {
    if (medium_.luminance->world_from_index == medium_.density->world_from_index)
      return index_->at(voxel);
    return index_->at(glm::dvec3(to_luminance_ * glm::dvec4(voxel, 1)));
  }

  const Medium& medium_;
  std::optional<FieldIndex> index_;  ///< of the grid that L comes from
  glm::dmat4 to_luminance_{1};
};

/// Values at all voxels of some blocks of the density, as a field of its transform.
Field field_of_blocks(const Field& density, const std::vector<glm::ivec3>& origins, int channels,
                      std::shared_ptr<float[]> values) {
  Field field;
  field.name = "light";
  field.value_type = channels == 3 ? "vec3s" : "float";
  field.channels = channels;
  // One voxel more: on the faces of the density's domain there is light too.
  field.active_box = {density.active_box.min - 1, density.active_box.max + 1};
  field.active_voxels = 512 * origins.size();
  field.world_from_index = density.world_from_index;
  for (std::size_t i = 0; i < origins.size(); ++i)
    field.leaves.push_back(
        {origins[i], values.get() + i * 512 * static_cast<std::size_t>(channels)});
  field.storage = std::move(values);
  return field;
}

}  // namespace

View lit(View view, const LightDepths& depths, const Progress& progress) {
  Medium& medium = view.medium;
  if (!medium.light) return view;
  const ScatteredLight light = *medium.light;
  const std::vector<glm::ivec3> origins = visible_blocks(*medium.density, density_options(view));
  // One luminance at all leaves the colour a factor, and the grid scalar unless that has colours.
  const bool alone = medium.color == glm::dvec3(0);
  const int channels = alone && !light.tinted ? 1 : 3;
  const OwnLuminance own(medium);

  const auto values = std::make_shared_for_overwrite<float[]>(origins.size() * 512 *
                                                              static_cast<std::size_t>(channels));
  float* to = values.get();
  for (std::size_t first = 0; first < origins.size(); first += batch) {
    const std::size_t count = std::min(batch, origins.size() - first);
    const std::vector<double> part = depths(std::span(origins).subspan(first, count));
    for (std::size_t i = 0; i < part.size(); ++i) {
      const double T = std::exp(-part[i]);
      if (channels == 1) {
        *to++ = static_cast<float>(T);
        continue;
      }
      const int n = static_cast<int>(i % 512);
      const glm::dvec3 glow =
          own.at(origins[first + i / 512] + glm::ivec3(n >> 6, (n >> 3) & 7, n & 7));
      const glm::dvec3 scattered = alone ? glm::dvec3(T) : light.radiance * T;
      const glm::dvec3 L = medium.color * glow + (light.tinted ? glow * scattered : scattered);
      for (int c = 0; c < 3; ++c) *to++ = static_cast<float>(L[c]);
    }
    if (progress)
      progress(static_cast<double>(first + count) / static_cast<double>(origins.size()));
  }

  medium.luminance =
      std::make_shared<const Field>(field_of_blocks(*medium.density, origins, channels, values));
  medium.source = channels == 3 ? LuminanceSource::vector : LuminanceSource::scalar;
  medium.color = alone ? light.radiance : glm::dvec3(1);
  if (view.scene.phase_g != 0) {
    medium.phase_axis = light.direction;
    medium.phase_g = view.scene.phase_g;
  }
  medium.light.reset();
  return view;
}

View light_march(const View& view) {
  View towards = view;
  Scene& scene = towards.scene;
  scene.mode = Mode::alpha;
  scene.sampling = Sampling::cells;
  scene.step.reset();
  scene.integrator = Integrator::psi_weighted;
  // between knots of values the attenuation is a cubic, whose depth is exact
  scene.split_knots = !view.medium.gradient;
  if (scene.split_knots) scene.segments = 1;
  scene.early_termination = 0;
  scene.filter = Filter::exact;
  scene.pixel_samples = 1;
  Medium& medium = towards.medium;
  medium.source = LuminanceSource::constant;
  medium.luminance.reset();
  medium.emission.reset();
  Camera& camera = towards.camera;
  camera = {};
  camera.forward = -medium.light->direction;
  camera.orthographic = true;
  medium.light.reset();
  return towards;
}

}  // namespace psivox
