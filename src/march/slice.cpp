#include "march/slice.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "march/film.h"
#include "psivox/clip.h"
#include "psivox/error.h"
#include "psivox/stopwatch.h"
#include "scene/field_index.h"

namespace psivox {
namespace {

class Slice {
 public:
  explicit Slice(const View& view)
      : view_(view),
        values_(*view.medium.density),
        domain_(view.medium.density->domain()),
        index_from_world_(glm::inverse(view.medium.density->world_from_index)),
        clip_(clip_of(view.scene)) {
    if (!view.scene.slice || !view.scene.slice->point)
      throw Error(ExitCode::failure, "the slice's plane is still to be placed");
    plane_ = *view.scene.slice;
  }

  /// Adds the pixel's ray: opaque where it meets the plane inside the domain and the clip.
  void add(const glm::dvec2& pixel, PixelSums& sums) const {
    const WorldRay ray = camera_ray(view_.camera, view_.scene.resolution, pixel.x, pixel.y);
    const double t = glm::dot(plane_.normal, *plane_.point - ray.origin) /
                     glm::dot(plane_.normal, ray.direction);
    const glm::dvec2 part = clip_interval(clip_, ray);
    const glm::dvec3 at(index_from_world_ * glm::dvec4(ray.origin + t * ray.direction, 1));
    if (!(t >= part.x && t <= part.y) || !inside(at))
      return sums.add(glm::dvec4(0), {no_depth, 1, 0, 0});
    sums.add(glm::dvec4(color(values_.at(at).x), 1), {t, 0, 0, 1});
  }

 private:
  bool inside(const glm::dvec3& at) const {
    for (int axis = 0; axis < 3; ++axis)
      if (!(at[axis] >= domain_.min[axis] && at[axis] <= domain_.max[axis])) return false;
    return true;
  }

  glm::dvec3 color(double value) const {
    const TransferFunction* function = view_.medium.transfer.get();
    if (!function) return view_.medium.color * value;
    const TransferPoint point = function->at(value);
    return view_.medium.color *
           (function->has_color() ? point.color : glm::dvec3(point.attenuation));
  }

  const View& view_;
  FieldIndex values_;
  Box domain_;
  glm::dmat4 index_from_world_;
  std::vector<HalfSpace> clip_;
  Plane plane_;
};

}  // namespace

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
