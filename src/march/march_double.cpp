#include "march/march_double.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <thread>

#include "base/stopwatch.h"
#include "march/atlas_march.h"
#include "march/film.h"
#include "march/light.h"

// Under AddressSanitizer it would take minutes to compile.
#ifdef __SANITIZE_ADDRESS__
#define PSIVOX_INLINED
#else
#define PSIVOX_INLINED [[gnu::flatten]]
#endif

namespace psivox {

PSIVOX_INLINED void glsl::march_on(AtlasMarch& march, AtlasMarch::March& state,
                                   const AtlasMarch::Ray& ray) {
  march.march(state, ray);
}

namespace {

using glsl::AtlasMarch;

/// A ray on its way.
struct RayOfPixel {
  AtlasMarch::Pixel pixel;
  AtlasMarch::Ray ray;
  AtlasMarch::March state;

  RayOfPixel(AtlasMarch& march, const glm::dvec2& at)
      : pixel(march.make_pixel(at)), ray(march.march_ray_of(pixel)), state(march.begin_march(ray)) {
    march.aim(state, pixel);
  }
  glm::dvec4 picture(AtlasMarch& march) const { return march.drawn(state, ray); }
};

MarchSetup setup_in_double(const View& view, const MediumAtlas& atlas,
                           const RenderOptions& options) {
  MarchSetup setup = make_march_setup(view, atlas, options);
  setup.constants.hardware_filter = false;
  setup.constants.octants = atlas.density.pages.octants;
  return setup;
}

/// Calls body(march, i) for i below `count`, `grain` at a time, on all threads.
template <typename Body>
void for_each(const MarchSetup& setup, const MediumAtlas& atlas, std::size_t count,
              std::size_t grain, const Progress& progress, const Body& body) {
  std::atomic<std::size_t> done = 0;
  const auto caller = std::this_thread::get_id();
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      AtlasMarch march(setup, atlas);
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        body(march, i);
                        ++done;
                        if (progress && std::this_thread::get_id() == caller)
                          progress(double(done) / double(count));
                      }
                    });
}

void turn(AtlasMarch& march, AtlasMarch::March& m, AtlasMarch::CellWalk& walk,
          const AtlasMarch::Ray& ray) {
  march.turn_cells(m, walk, ray);
  if (m.t >= ray.end) m.done = true;
  if (!march.depth_only) m.transmittance = march.decay(m.optical_depth).e;
}

/// Marches a ray by exact cells, one turn after the other. Calls visit(before, walk_before) after
/// each that goes on.
template <typename Visit>
void for_turns(AtlasMarch& march, RayOfPixel& ray, const Visit& visit) {
  AtlasMarch::CellWalk walk = march.begin_cells();
  AtlasMarch::March& m = ray.state;
  for (int still = 0; !m.done && still < march.turns_of_product;) {
    const AtlasMarch::March before = m;
    const AtlasMarch::CellWalk walk_before = walk;
    turn(march, m, walk, ray.ray);
    still = m.t > before.t ? 0 : still + 1;
    if (!still) visit(before, walk_before);
  }
}

/// Collects the curve of a ray.
class CurveMarch {
 public:
  /// Between its points the curve is linear to a sixteenth of `tolerance`.
  CurveMarch(AtlasMarch& march, const glm::dvec2& at, double tolerance)
      : march_(march), tolerance_(tolerance), ray_(march, at) {}

  RayCurve curve() {
    RayCurve curve{point(ray_.state)};
    for_turns(march_, ray_,
              [&](const AtlasMarch::March& before, const AtlasMarch::CellWalk& walk_before) {
                add_inside(before, walk_before, point(ray_.state), curve);
                curve.push_back(point(ray_.state));
              });
    return curve;
  }

 private:
  CurvePoint point(const AtlasMarch::March& m) {
    const double along = march_.orthographic ? 1 : ray_.pixel.inverse_length;
    return {(m.t - march_.camera_time(ray_.pixel)) * along * march_.world_unit, m.optical_depth,
            glm::dvec3(march_.drawn(m, ray_.ray))};
  }

  /// Points inside the piece that a turn has crossed, as many as its change asks for: the part of a
  /// cubic's integral that is not linear is at most a quarter of it, and n parts have 1/n^2 of
  /// that.
  void add_inside(const AtlasMarch::March& before, const AtlasMarch::CellWalk& walk_before,
                  const CurvePoint& back, RayCurve& curve) {
    const CurvePoint front = curve.back();
    const glm::dvec3 light = glm::abs(back.radiance - front.radiance);
    const double change =
        std::max({std::exp(-front.depth) - std::exp(-back.depth), light.x, light.y, light.z});
    const int parts = int(std::clamp(std::ceil(2 * std::sqrt(change / tolerance_)), 1.0, 64.0));
    AtlasMarch::Ray part = ray_.ray;
    for (int i = 1; i < parts; ++i) {
      AtlasMarch::March m = before;
      AtlasMarch::CellWalk walk = walk_before;
      part.end = before.t + (ray_.state.t - before.t) * i / parts;
      turn(march_, m, walk, part);
      curve.push_back(point(m));
    }
  }

  AtlasMarch& march_;
  double tolerance_;
  RayOfPixel ray_;
};

/// Rays that a thread takes at a time.
constexpr std::size_t rays_together = 4;

MarchedRay shown(AtlasMarch& march, const RayOfPixel& ray) {
  return {glm::vec4(ray.picture(march)), double(ray.state.samples)};
}

}  // namespace

RenderResult render_march_double(const View& view, const MediumAtlas& atlas,
                                 const RenderOptions& options) {
  const Stopwatch watch;
  const MarchSetup setup = setup_in_double(view, atlas, options);
  const PixelBox pixels = options.pixels.value_or(PixelBox{{}, view.scene.resolution});
  const glm::ivec2 size = pixels.size;
  const int n = view.scene.pixel_samples;

  Film film(view, options);
  std::atomic<std::uint64_t> stuck = 0;
  for_each(setup, atlas, std::size_t(size.y), 4, options.progress,
           [&](AtlasMarch& march, std::size_t row) {
             const int y = int(row);
             for (int x = 0; x < size.x; ++x) {
               PixelSums sums;
               for (int i = 0; i < n; ++i) {
                 march.sample_offset = options.place.value_or(pixel_sample(i, n));
                 RayOfPixel ray(march, pixels.origin + glm::ivec2(x, y));
                 march_on(march, ray.state, ray.ray);
                 const auto& m = ray.state;
                 if (m.stuck) ++stuck;
                 sums.add(ray.picture(march), {march.depth_of(m, ray.pixel),
                                               march.decay(m.optical_depth).e, m.steps, m.samples});
               }
               film.set(x, y, sums);
             }
           });

  RenderResult result;
  result.image = film.finish(result.stats);
  result.stats.renderer = "march in double precision";
  result.stats.passes = 1;
  result.stats.stuck = stuck;
  result.stats.march_ms = watch.ms();
  return result;
}

std::vector<std::vector<Crossed>> crossed_cells(const View& view, const MediumAtlas& atlas,
                                                std::span<const glm::dvec2> places) {
  MarchSetup setup = setup_in_double(depth_march(view, 0), atlas, {});
  setup.parameters.sample_offset = glm::dvec2(0);
  std::vector<std::vector<Crossed>> found(places.size());
  for_each(setup, atlas, places.size(), rays_together, {}, [&](AtlasMarch& march, std::size_t i) {
    RayOfPixel ray(march, places[i]);
    const double camera = march.camera_time(ray.pixel), unit = march.world_unit;
    for_turns(march, ray, [&](const AtlasMarch::March& before, const AtlasMarch::CellWalk&) {
      const AtlasMarch::March& m = ray.state;
      const double depth = m.optical_depth - before.optical_depth;
      if (depth > 0) found[i].push_back({(before.t - camera) * unit, (m.t - camera) * unit, depth});
    });
  });
  return found;
}

RenderResult render_deep(const View& view, const MediumAtlas& atlas, double tolerance,
                         const Progress& progress) {
  const Stopwatch watch;
  const MarchSetup setup = setup_in_double(view, atlas, {});
  const glm::ivec2 size = view.scene.resolution;
  const int n = view.scene.pixel_samples;
  Film film(view, {});
  std::vector<std::vector<DeepSample>> rows(std::size_t(size.y));
  DeepPixels deep;
  deep.counts.resize(std::size_t(size.x) * std::size_t(size.y));
  for_each(setup, atlas, rows.size(), 4, progress, [&](AtlasMarch& march, std::size_t y) {
    std::vector<DeepSample>& row = rows[y];
    for (int x = 0; x < size.x; ++x) {
      std::vector<RayCurve> rays;
      for (int i = 0; i < n; ++i) {
        march.sample_offset = pixel_sample(i, n);
        rays.push_back(CurveMarch(march, {x, int(y)}, tolerance).curve());
      }
      const std::size_t before = row.size();
      fit_samples(mean_curve(rays), tolerance * 15 / 16, row);
      const std::size_t count = row.size() - before;
      deep.counts[y * std::size_t(size.x) + std::size_t(x)] = std::uint32_t(count);
      *film.pixel(x, int(y)) = flattened(row.data() + before, count);
    }
  });
  for (const auto& row : rows) deep.samples.insert(deep.samples.end(), row.begin(), row.end());
  RenderResult result;
  result.image = film.finish(result.stats);
  result.image.deep = std::move(deep);
  result.stats.renderer = "march in double precision";
  result.stats.march_ms = watch.ms();
  return result;
}

PixelMarch::PixelMarch(const View& view, const MediumAtlas& atlas, const BrickSteps& brick_steps,
                       const BrickCodes* codes)
    : atlas_(&atlas), codes_(codes) {
  MarchSetup setup = setup_in_double(view, atlas, {.count = true, .brick_steps = brick_steps});
  setup.parameters.sample_offset = pixel_sample(0, 1);
  setup_ = std::make_shared<const MarchSetup>(std::move(setup));
}

void PixelMarch::march(std::span<const glm::ivec2> pixels, std::span<MarchedRay> rays,
                       const Progress& progress, const PixelMarch* sooner,
                       std::span<MarchedRay> ended) const {
  const double last = setup_->parameters.stop_depth;
  for_each(sooner ? *sooner->setup_ : *setup_, *atlas_, pixels.size(), rays_together, progress,
           [&](AtlasMarch& march, std::size_t i) {
             if (codes_) march.read_as(*codes_);
             RayOfPixel ray(march, pixels[i]);
             march_on(march, ray.state, ray.ray);
             if (sooner) {
               ended[i] = shown(march, ray);
               ray.state.stop_at = last;
               if (ray.state.t < ray.ray.end) {
                 ray.state.done = false;
                 march_on(march, ray.state, ray.ray);
               }
             }
             rays[i] = shown(march, ray);
           });
}

}  // namespace psivox
