#include "reference/reference.h"
#include "scene/cuts.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "base/stopwatch.h"
#include "medium/backdrop.h"
#include "psivox/error.h"
#include "ray_radiance.h"

namespace psivox {
namespace {

constexpr int tile_width = 8;  // small enough to share a 64 x 64 picture among many cores

/// The depth is the mean of the samples that have one, if most samples do.
RayPicture integrate_pixel(const View& view, RayModes& modes, int x, int y) {
  const int n = view.scene.pixel_samples;
  RayPicture sum;
  double depth = 0;
  int with_depth = 0;
  for (int i = 0; i < n; ++i) {
    const glm::dvec2 place = pixel_sample(i, n);
    const WorldRay ray = camera_ray(view.camera, view.scene.resolution, x + place.x, y + place.y);
    const RayPicture r = modes.picture(
        ray, held_at(view.holdout.get(), view.camera, view.scene.resolution, {x, y}, ray));
    sum.radiance += r.radiance;
    sum.opacity += r.opacity;
    sum.error += r.error;
    sum.cells += r.cells;
    if (!std::isfinite(r.depth)) continue;
    depth += r.depth;
    ++with_depth;
  }
  sum.radiance /= n;
  sum.opacity /= n;
  sum.error /= n;
  if (2 * with_depth > n) sum.depth = depth / with_depth;
  return sum;
}

/// Maxima and surfaces are at one place of the ray.
bool has_depth(const Scene& scene) {
  return scene.shows(Shows::value) || scene.shows(Shows::surface);
}

}  // namespace

/// Sets a pixel of the picture and of its layers `error` and, if it has one, `depth`.
static void set_pixel(Image& image, int x, int y, const RayPicture& p) {
  const std::size_t i = image.index(x, y);
  float* rgba = image.layers[0].values.data() + 4 * i;
  for (int c = 0; c < 3; ++c) rgba[c] = float(p.radiance[c]);
  rgba[3] = float(p.opacity);
  image.layers[1].values[i] = float(p.error);
  if (image.layers.size() > 2) image.layers[2].values[i] = float(p.depth);
}

/// Calls body(i, draw) for i below `count`, on many threads, where draw(x, y) is the RayPicture of
/// a pixel. `progress` is called on this thread.
template <typename Body>
static void for_each(const View& view, double tolerance, const Progress& progress, int count,
                     const Body& body) {
  if (view.medium.light) throw Error(ExitCode::failure, "the view's light is still to be computed");
  const RayMedium medium(view.medium);
  tbb::enumerable_thread_specific<RayModes> modes(
      [&] { return RayModes(view, medium, tolerance); });
  std::atomic<int> done = 0;
  const std::thread::id caller = std::this_thread::get_id();
  tbb::parallel_for(
      0, count,
      [&](int i) {
        body(i, [&](int x, int y) { return integrate_pixel(view, modes.local(), x, y); });
        const int now = ++done;
        if (progress && std::this_thread::get_id() == caller) progress(double(now) / count);
      },
      tbb::simple_partitioner());
  if (progress) progress(1);
}

/// Calls `take(x, y, RayPicture)` with every pixel, on many threads.
template <typename Take>
static void each_pixel(const View& view, double tolerance, const Progress& progress,
                       const Take& take) {
  const int width = view.scene.resolution.x, height = view.scene.resolution.y;
  const int columns = (width + tile_width - 1) / tile_width;
  const int rows = (height + tile_width - 1) / tile_width;
  for_each(view, tolerance, progress, columns * rows, [&](int tile, const auto& draw) {
    const int x0 = tile % columns * tile_width, y0 = tile / columns * tile_width;
    for (int y = y0; y < std::min(y0 + tile_width, height); ++y)
      for (int x = x0; x < std::min(x0 + tile_width, width); ++x) take(x, y, draw(x, y));
  });
}

RenderResult render_reference(const View& view, double tolerance, const Progress& progress) {
  const Stopwatch watch;
  const int width = view.scene.resolution.x, height = view.scene.resolution.y;
  RenderResult result;
  result.image = rgba_image(width, height);
  const std::size_t pixels = result.image.pixels();
  result.image.layers.push_back({"error", {"error"}, std::vector<float>(pixels)});
  if (has_depth(view.scene))
    result.image.layers.push_back({"depth", {"depth"}, std::vector<float>(pixels)});

  std::atomic<std::uint64_t> cells = 0;
  each_pixel(view, tolerance, progress, [&](int x, int y, const RayPicture& p) {
    set_pixel(result.image, x, y, p);
    cells += p.cells;
  });
  result.stats.rays = pixels * std::size_t(view.scene.pixel_samples);
  result.stats.cells = cells;
  result.stats.march_ms = watch.ms();
  return result;
}

Layer bound_layer(const View& view, const Image& picture, double tolerance,
                  const Progress& progress) {
  const Backdrop behind(view);
  Layer layer{"bound", {"bound"}, std::vector<float>(picture.rgba().size() / 4)};
  each_pixel(view, tolerance, progress, [&](int x, int y, const RayPicture& p) {
    const std::size_t i = picture.index(x, y);
    const float* const drawn = &picture.rgba()[4 * i];
    const glm::dvec4 exact(p.radiance, p.opacity);
    const glm::dvec4 seen =
        behind.seen(glm::dvec4(drawn[0], drawn[1], drawn[2], drawn[3]) - exact, i);
    const glm::dvec3 back = behind.at(i);
    const double most = std::max({back.x, back.y, back.z});
    double off = 0;
    for (int c = 0; c < 4; ++c)
      off = std::isnan(seen[c]) ? infinity : std::max(off, std::abs(seen[c]));
    // the sum with what is behind is rounded: its two factors, itself and the transmittance
    const double brightest = double(std::max({drawn[0], drawn[1], drawn[2]}));
    off += p.error * (1 + most) + (most > 0 ? 0x1p-23 * (brightest + 2 * most) : 0);
    const float stored = float(off);
    layer.values[i] =
        double(stored) < off ? std::nextafter(stored, std::numeric_limits<float>::max()) : stored;
  });
  return layer;
}

std::vector<glm::dvec4> reference_pixels(const View& view, std::span<const glm::ivec2> pixels,
                                         double tolerance, const Progress& progress) {
  std::vector<glm::dvec4> result(pixels.size());
  for_each(view, tolerance, progress, int(pixels.size()), [&](int i, const auto& draw) {
    const glm::ivec2 pixel = pixels[std::size_t(i)];
    const RayPicture p = draw(pixel.x, pixel.y);
    result[std::size_t(i)] = glm::dvec4(p.radiance, p.opacity);
  });
  return result;
}

namespace {

/// What attenuates in a view, all volumes together.
Medium all_attenuation(const View& view, const Beam& beam) {
  Medium medium = light_march(view, beam).medium;
  medium.others = view.medium.others;
  for (Medium& other : medium.others) {
    other.color = medium.color;
    other.lit = false;
    other.emission.clear();
  }
  return medium;
}

/// Optical depths from voxels towards a beam.
class VoxelDepths {
 public:
  VoxelDepths(const View& view, const Beam& beam)
      : medium_(all_attenuation(view, beam)), towards_(-beam.direction) {}

  double operator()(const glm::ivec3& voxel) {
    const glm::dmat4& world_from_index = medium_.medium.density->world_from_index;
    const glm::dvec3 at(world_from_index * glm::dvec4(voxel, 1));
    return workers_.local().whole_depth({at, towards_}).optical_depth;
  }

 private:
  RayMedium medium_;
  glm::dvec3 towards_;
  tbb::enumerable_thread_specific<RayIntegrator> workers_{
      [this] { return RayIntegrator(medium_, 1e-12); }};
};

}  // namespace

LightDepths reference_light_depths(const View& view, std::size_t volume) {
  return one_by_one([seen = seen_from(view, volume)](const Beam& beam, LightBlocks blocks,
                                                     const TakeDepths& take,
                                                     const Progress& progress) {
    VoxelDepths depth(seen, beam);
    take_blocks(blocks, std::ref(depth), take, progress);
  });
}

std::vector<double> reference_light_depths(const View& view, const Beam& beam,
                                           std::span<const glm::ivec3> voxels) {
  VoxelDepths depth(view, beam);
  return depths_of(voxels, std::ref(depth));
}

namespace {

Layer transmittance_layer(const Image& image) {
  Layer layer{"transmittance", {"transmittance"}, {}};
  const auto rgba = image.rgba();
  layer.values.reserve(rgba.size() / 4);
  for (std::size_t i = 3; i < rgba.size(); i += 4) layer.values.push_back(1 - rgba[i]);
  return layer;
}

}  // namespace

RenderResult ReferenceMarcher::render(const View& view, const RenderOptions& options) {
  RenderResult result = render_reference(view, 1e-12, options.progress);
  result.stats.renderer = description();
  if (options.transmittance) result.image.layers.push_back(transmittance_layer(result.image));
  return result;
}

}  // namespace psivox
