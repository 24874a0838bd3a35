#include "march/march_double.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <thread>

#include "march/atlas_march.h"
#include "march/film.h"
#include "psivox/stopwatch.h"

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
  glm::dvec4 picture(AtlasMarch& march) const { return march.drawn(state, ray, pixel); }
};

MarchSetup setup_in_double(const View& view, const MediumAtlas& atlas,
                           const RenderOptions& options) {
  MarchSetup setup = make_march_setup(view, atlas, options);
  setup.constants.hardware_filter = false;
  setup.constants.octants = setup.constants.passes_octants = atlas.density.pages.octants;
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

PixelMarch::PixelMarch(const View& view, const MediumAtlas& atlas, const BrickSteps& brick_steps)
    : atlas_(&atlas) {
  MarchSetup setup = setup_in_double(view, atlas, {.count = true, .brick_steps = brick_steps});
  setup.parameters.sample_offset = pixel_sample(0, 1);
  setup_ = std::make_shared<const MarchSetup>(std::move(setup));
}

namespace {

/// Rays that a thread takes at a time.
constexpr std::size_t rays_together = 4;

MarchedRay shown(AtlasMarch& march, const RayOfPixel& ray) {
  return {glm::vec4(ray.picture(march)), double(ray.state.samples)};
}

}  // namespace

void PixelMarch::march(std::span<const glm::ivec2> pixels, std::span<MarchedRay> rays,
                       const Progress& progress) const {
  for_each(*setup_, *atlas_, pixels.size(), rays_together, progress,
           [&](AtlasMarch& march, std::size_t i) {
             RayOfPixel ray(march, pixels[i]);
             march_on(march, ray.state, ray.ray);
             rays[i] = shown(march, ray);
           });
}

void PixelMarch::march(std::span<const glm::ivec2> pixels, std::span<MarchedRay> rays,
                       const PixelMarch& sooner, std::span<MarchedRay> ended,
                       const Progress& progress) const {
  const double last = setup_->parameters.stop_depth;
  for_each(*sooner.setup_, *atlas_, pixels.size(), rays_together, progress,
           [&](AtlasMarch& march, std::size_t i) {
             RayOfPixel ray(march, pixels[i]);
             march_on(march, ray.state, ray.ray);
             ended[i] = shown(march, ray);
             ray.state.stop_at = last;
             if (ray.state.t < ray.ray.end) {
               ray.state.done = false;
               march_on(march, ray.state, ray.ray);
             }
             rays[i] = shown(march, ray);
           });
}

}  // namespace psivox
