#include "march/film.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/stopwatch.h"
#include "base/text.h"
#include "field/field_index.h"
#include "field/index_space.h"
#include "field/leaf_values.h"
#include "psivox/error.h"
#include "psivox/medium.h"
#include "scene/cuts.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

Plane placed_plane(const Scene& scene) {
  if (!scene.slice || !scene.slice->point)
    throw Error(ExitCode::failure, "the slice's plane is still to be placed");
  return *scene.slice;
}

/// Whether a point of the plane is interpolated from a leaf's values.
bool passes(const Plane& plane, const Leaf& leaf, const glm::dmat4& world_from_index) {
  double least = HUGE_VAL, most = -HUGE_VAL;
  for (int i = 0; i < 8; ++i) {
    const glm::ivec3 corner = leaf.origin - 1 + 9 * cube_corner(i);
    const glm::dvec3 at(world_from_index * glm::dvec4(corner, 1));
    const double distance = glm::dot(plane.normal, at - *plane.point);
    least = std::min(least, distance);
    most = std::max(most, distance);
  }
  const double rounding = 1e-9 * (most - least);
  return least <= rounding && most >= -rounding;
}

/// A field with the leaves alone that a plane passes, in memory.
Field on_plane(const Field& field, const Scene& scene) {
  const Plane plane = placed_plane(scene);
  const auto wanted = [&](const Leaf& leaf) { return passes(plane, leaf, field.world_from_index); };
  const std::uint64_t most = field.reader ? grid_memory(scene) : 0;
  const std::uint64_t needed = std::uint64_t(std::ranges::count_if(field.leaves, wanted)) * 512 *
                               sizeof(float) * std::uint64_t(field.channels);
  if (most > 0 && needed > most)
    throw Error(ExitCode::memory, "grid '" + field.name + "': the slice passes " +
                                      mebibytes(needed) + " of its values, over the limit of " +
                                      mebibytes(most) + " for grids; raise --memory-limit");
  return part_of_field(field, wanted);
}

/// The values of a field on the scene's plane.
class PlaneValues {
 public:
  PlaneValues(const Field& field, const Scene& scene)
      : field_(on_plane(field, scene)),
        values_(field_),
        index_from_world_(glm::inverse(field.world_from_index)) {}

  PlaneValues(const PlaneValues&) = delete;  // the index has the field's address

  const FieldIndex& index() const { return values_; }
  glm::dvec3 index_at(const glm::dvec3& world) const {
    return glm::dvec3(index_from_world_ * glm::dvec4(world, 1));
  }

 private:
  Field field_;
  FieldIndex values_;
  glm::dmat4 index_from_world_;
};

class Slice {
 public:
  explicit Slice(const View& view)
      : view_(view),
        density_(*view.medium.density, view.scene),
        box_(view.medium.density->active_box),
        clip_(clip_of(view.scene)),
        plane_(placed_plane(view.scene)) {
    if (view.medium.luminance) luminance_.emplace(*view.medium.luminance, view.scene);
  }

  /// Adds the pixel's ray: opaque where it meets the plane between the voxels and inside the clip.
  void add(const glm::dvec2& pixel, PixelSums& sums) const {
    const WorldRay ray = camera_ray(view_.camera, view_.scene.resolution, pixel.x, pixel.y);
    const double t = glm::dot(plane_.normal, *plane_.point - ray.origin) /
                     glm::dot(plane_.normal, ray.direction);
    glm::dvec2 part = clip_interval(clip_, ray);
    part.y = std::min(part.y, held_at(view_.holdout.get(), view_.camera, view_.scene.resolution,
                                      glm::ivec2(pixel), ray));
    const glm::dvec3 world = ray.origin + t * ray.direction;
    const glm::dvec3 at = density_.index_at(world);
    if (!(t >= part.x && t <= part.y) || !inside(at))
      return sums.add(glm::dvec4(0), {no_depth, 1, 0, 0});
    const FieldIndex& density = density_.index();
    const double value = view_.medium.nearest ? density.at(nearest_voxel(at)).x : density.at(at).x;
    if (std::isnan(value)) return sums.add(glm::dvec4(0), {no_depth, 1, 0, 0});  // absent
    sums.add(glm::dvec4(view_.medium.color * shown(value, world), 1), {t, 0, 0, 1});
  }

 private:
  /// In the box of the outermost voxels, beyond which values would fall to 0.
  bool inside(const glm::dvec3& at) const {
    constexpr double rounding = 1e-6;  // of a plane through voxels, in an array of 2^24 of them
    for (int axis = 0; axis < 3; ++axis)
      if (!(at[axis] >= box_.min[axis] - rounding && at[axis] <= box_.max[axis] + rounding))
        return false;
    return true;
  }

  /// A grid of luminance, or else what the density is by its function, if it has one.
  glm::dvec3 shown(double value, const glm::dvec3& world) const {
    if (luminance_) {
      const glm::dvec3 luminance = luminance_->index().at(luminance_->index_at(world));
      return view_.medium.luminance->channels == 3 ? luminance : glm::dvec3(luminance.x);
    }
    const TransferFunction* function = view_.medium.transfer.get();
    if (!function) return glm::dvec3(value);
    const TransferPoint point = function->at(value);
    return function->has_color() ? point.color : glm::dvec3(point.attenuation);
  }

  const View& view_;
  PlaneValues density_;
  std::optional<PlaneValues> luminance_;
  Box box_;
  std::vector<HalfSpace> clip_;
  Plane plane_;
};

}  // namespace

View slice_view(View view) {
  const Medium whole = std::move(view.medium);
  view.medium = {};
  Field shown = on_plane(*whole.density, view.scene);
  // the march ends where the domain does; a domain without a width has no inside
  const glm::ivec3 size = shown.active_box.max - shown.active_box.min;
  if (size.x > 0 && size.y > 0 && size.z > 0) shown.margin = 0;
  view.medium.density = std::make_shared<const Field>(std::move(shown));
  view.medium.color = whole.color;
  view.medium.transfer = whole.transfer;
  view.medium.nearest = whole.nearest;
  const bool colored = whole.transfer && whole.transfer->has_color();
  view.medium.source = colored ? LuminanceSource::transfer : LuminanceSource::density;
  if (whole.luminance) {
    view.medium.source = whole.source;
    view.medium.luminance = std::make_shared<const Field>(on_plane(*whole.luminance, view.scene));
  }
  return view;
}

RenderResult draw_slice(const View& view, const RenderOptions& options) {
  const Stopwatch watch;
  const Slice slice(view);
  const glm::ivec2 size = view.scene.resolution;
  const int n = view.scene.pixel_samples;
  Film film(view, options);
  tbb::parallel_for(tbb::blocked_range<int>(0, size.y, 4), [&](const auto& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y)
      for (int x = 0; x < size.x; ++x) {
        PixelSums sums;
        for (int i = 0; i < n; ++i) slice.add(glm::dvec2(x, y) + pixel_sample(i, n), sums);
        film.set(x, y, sums);
      }
  });
  RenderResult result;
  result.image = film.finish(result.stats);
  result.stats.renderer = "slice in double precision";
  result.stats.passes = 1;
  result.stats.march_ms = watch.ms();
  return result;
}

}  // namespace psivox
