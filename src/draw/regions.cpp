#include "draw/regions.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>
#include <string>

#include "draw/trial_method.h"
#include "psivox/camera.h"
#include "psivox/error.h"
#include "psivox/leaf_values.h"
#include "psivox/parts.h"
#include "psivox/text.h"

namespace psivox {
namespace {

constexpr int far_away = 1 << 28;  // [bricks]: beyond every grid

/// The rays' state behind the regions that were drawn.
class Rays {
 public:
  Rays(const glm::ivec2& size, int samples)
      : samples_(std::size_t(samples)),
        width_(std::size_t(size.x)),
        pixels_(width_ * std::size_t(size.y)),
        rays_(samples_ * pixels_, glm::dvec4(0, 0, 0, 1)) {}

  /// Adds what a region shows to one sample of the pixels that its image begins at.
  void add(const Image& region, const glm::ivec2& origin, std::size_t sample) {
    const auto rgba = region.rgba();
    const std::vector<float>& transmittance = region.layers[1].values;  // there is no depth
    std::size_t i = 0;
    for (int y = 0; y < region.height; ++y) {
      glm::dvec4* ray = rays_.data() + sample * pixels_ + std::size_t(origin.y + y) * width_ +
                        std::size_t(origin.x);
      for (int x = 0; x < region.width; ++x, ++i, ++ray) {
        const double before = ray->a;
        for (int c = 0; c < 3; ++c) (*ray)[c] += before * double(rgba[4 * i + std::size_t(c)]);
        ray->a *= double(transmittance[i]);
      }
    }
  }

  /// The means over samples.
  Image picture(const glm::ivec2& size, bool transmittance) const {
    Image image{size.x, size.y, {{"", {"R", "G", "B", "A"}, std::vector<float>(4 * pixels_)}}, {}};
    std::vector<float> left(pixels_);
    for (std::size_t i = 0; i < pixels_; ++i) {
      glm::dvec4 sum(0);
      for (std::size_t sample = 0; sample < samples_; ++sample) sum += rays_[sample * pixels_ + i];
      sum /= double(samples_);
      for (int c = 0; c < 3; ++c) image.rgba()[4 * i + std::size_t(c)] = float(sum[c]);
      image.rgba()[4 * i + 3] = float(1 - sum.a);
      left[i] = float(sum.a);
    }
    if (transmittance)
      image.layers.push_back({"transmittance", {"transmittance"}, std::move(left)});
    return image;
  }

 private:
  std::size_t samples_, width_, pixels_;
  std::vector<glm::dvec4> rays_;  ///< R G B and transmittance, sample by sample
};

/// Pixels whose rays may meet a region, and one around them, for rounding.
PixelBox pixels_of(const View& view, const Box& bricks) {
  const PixelBox all{{}, view.scene.resolution};
  const Field& density = *view.medium.density;
  const Camera& camera = view.camera;
  if (view.medium.emission) return all;  // it may reach beyond the density
  const Box domain = density.domain();
  const glm::dvec3 low = glm::max(8.0 * glm::dvec3(bricks.min), glm::dvec3(domain.min));
  const glm::dvec3 high = glm::min(8.0 * glm::dvec3(bricks.max) + 8.0, glm::dvec3(domain.max));
  if (low.x >= high.x || low.y >= high.y || low.z >= high.z) return {};
  const glm::dvec2 size(all.size);
  glm::dvec2 first(HUGE_VAL), last(-HUGE_VAL);
  int behind = 0, beside = 0;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner = glm::mix(low, high, glm::dvec3(i >> 2, i >> 1 & 1, i & 1));
    const glm::dvec3 to =
        glm::dvec3(density.world_from_index * glm::dvec4(corner, 1)) - camera.position;
    const double along = camera.orthographic ? 1 : glm::dot(to, camera.forward);
    behind += along <= 0;
    beside += along <= 1e-3 * glm::length(to) && !camera.orthographic;
    const glm::dvec2 on(glm::dot(to, camera.right) / (along * camera.half_width),
                        glm::dot(to, camera.up) / (along * camera.half_height));
    const glm::dvec2 pixel(0.5 * (1 + on.x) * size.x, 0.5 * (1 - on.y) * size.y);
    first = glm::min(first, pixel);
    last = glm::max(last, pixel);
  }
  if (behind == 8) return {};
  if (beside > 0) return all;
  const glm::ivec2 from(glm::clamp(glm::floor(first) - 1.0, glm::dvec2(0), size));
  const glm::ivec2 to(glm::clamp(glm::floor(last) + 2.0, glm::dvec2(0), size));
  return {from, to - from};
}

void add_counts(const RenderStats& part, RenderStats& sum) {
  sum.renderer = part.renderer;
  sum.samples += part.samples;
  sum.steps += part.steps;
  sum.passes = std::max(sum.passes, part.passes);
  for (double RenderStats::*time :
       {&RenderStats::gl_init_ms, &RenderStats::shader_ms, &RenderStats::upload_ms,
        &RenderStats::march_ms, &RenderStats::gpu_ms, &RenderStats::cpu_ms})
    sum.*time += part.*time;
}

}  // namespace

Regions::Regions(std::vector<glm::ivec3> bricks, std::size_t most) {
  root_.box = {glm::ivec3(-far_away), glm::ivec3(far_away)};
  split(root_, bricks, std::max<std::size_t>(most, 1));
}

void Regions::split(Node& node, std::span<glm::ivec3> bricks, std::size_t most) {
  if (bricks.size() <= most) {
    ++count_;
    return;
  }
  glm::ivec3 low(far_away), high(-far_away);
  for (const glm::ivec3& brick : bricks) {
    low = glm::min(low, brick);
    high = glm::max(high, brick);
  }
  const glm::ivec3 extent = high - low;
  node.axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const int axis = node.axis;
  const auto along = [axis](const glm::ivec3& a, const glm::ivec3& b) { return a[axis] < b[axis]; };
  const auto middle = bricks.begin() + std::ptrdiff_t(bricks.size() / 2);
  std::nth_element(bricks.begin(), middle, bricks.end(), along);
  // bricks of one slice stay together: the plane is beside the median's
  node.plane = std::max((*middle)[axis], low[axis] + 1);
  const auto upper = std::partition(bricks.begin(), bricks.end(), [&](const glm::ivec3& brick) {
    return brick[axis] < node.plane;
  });
  const auto lower_count = std::size_t(upper - bricks.begin());
  node.lower = std::make_unique<Node>();
  node.upper = std::make_unique<Node>();
  node.lower->box = node.upper->box = node.box;
  node.lower->box.max[axis] = node.plane - 1;
  node.upper->box.min[axis] = node.plane;
  split(*node.lower, bricks.first(lower_count), most);
  split(*node.upper, bricks.subspan(lower_count), most);
}

std::vector<Box> Regions::ordered(const std::function<bool(const Node&)>& lower_first) const {
  std::vector<Box> boxes;
  std::vector<const Node*> open{&root_};
  while (!open.empty()) {
    const Node& node = *open.back();
    open.pop_back();
    if (!node.lower) {
      boxes.push_back(node.box);
      continue;
    }
    const bool lower = lower_first(node);
    open.push_back(lower ? node.upper.get() : node.lower.get());
    open.push_back(lower ? node.lower.get() : node.upper.get());
  }
  return boxes;
}

std::vector<Box> Regions::boxes() const {
  return ordered([](const Node&) { return true; });
}

std::vector<Box> Regions::front_to_back(const Camera& camera,
                                        const glm::dmat4& world_from_index) const {
  const glm::dmat4 to_index = glm::inverse(world_from_index);
  const glm::dvec3 eye(to_index * glm::dvec4(camera.position, 1));
  const glm::dvec3 forward = glm::dmat3(to_index) * camera.forward;
  return ordered([&](const Node& node) {
    return camera.orthographic ? forward[node.axis] > 0 : eye[node.axis] < 8.0 * node.plane;
  });
}

namespace {

/// Which pictures can be drawn region by region, if this one cannot; else empty.
std::string region_obstacle(const View& view, const Wish& wish) {
  if (std::string obstacle = parts_obstacle(view.scene); !obstacle.empty()) return obstacle;
  if (wish.time_budget_ms) return "pictures without --time-budget";
  const Layers& layers = wish.layers;
  if (layers.depth || layers.steps || layers.samples || layers.error)
    return "pictures without other layers than transmittance";
  return {};
}

/// More than the field's bricks can take on host and GPU [bytes].
double most_bytes(const Field& field) {
  double blocks = double(field.leaves.size());
  for (const Tile& tile : field.tiles) blocks += 6 * std::pow(tile.width / 8 + 1, 2);
  return 2 * 8 * blocks * brick_texels * sizeof(float) * field.channels;
}

/// What a view's grids take, on host or GPU [bytes].
struct Needs {
  double fixed = 0;    ///< however the view is split
  double texels = 0;   ///< of the density and its gradient, which are split
  double light = 0;    ///< of the light's texels, which are split, too
  double on_host = 0;  ///< values that a part reads from the file
  double bricks = 1;   ///< of the density
  /// On host and GPU, with all of them.
  double whole() const { return 2 * (fixed + texels + light); }
  /// The same with some of the bricks.
  double of_part(double count) const {
    // a part's light and the values that it reads have a margin of a brick
    const double grown = std::pow(std::cbrt(count) + 2, 3) / bricks;
    return 2 * (fixed + texels * count / bricks + light * grown) + on_host * grown;
  }
};

AtlasSize size_of(const Field& field, AtlasOptions options, TexelType texel) {
  options.texel = texel;
  return predict_atlas(field, options);
}

/// Of a density in memory, or of one whose values stay in the file, which splits by its topology.
Needs needs_of(const View& view, int light) {
  const Medium& medium = view.medium;
  const TexelType texel = view.scene.texel;
  Needs needs;
  if (medium.density->reader) {
    const double texel_bytes = texel == TexelType::float16 ? 2 : 4;
    needs.bricks = double(std::max<std::size_t>(leaf_bricks(*medium.density).size(), 1));
    needs.texels = needs.bricks * brick_texels * texel_bytes;
    needs.on_host = double(value_bytes(*medium.density));
  } else {
    const AtlasSize density = size_of(*medium.density, density_options(view), texel);
    needs.bricks = double(std::max<std::uint64_t>(density.textured_bricks, 1));
    needs.texels = double(density.texel_bytes);
    needs.light = light * double(density.texel_bytes);
    needs.fixed = double((1 + light) * (density.page_bytes + density.constant_bytes));
  }
  if (medium.gradient) {
    const AtlasSize gradient = size_of(*medium.gradient, {}, texel);
    needs.texels += double(gradient.texel_bytes);
    needs.fixed += double(gradient.bytes() - gradient.texel_bytes);
  }
  for (const auto& field : {light ? nullptr : medium.luminance, medium.emission})
    if (field) needs.fixed += double(size_of(*field, {}, texel).bytes());
  return needs;
}

/// Memory that is left for atlases beside the fields, or half of it all [bytes].
double left_beside_fields(const View& view, double limit) {
  const Field& density = *view.medium.density;
  constexpr double stored_leaf = 32;  // origin, pointer and place
  const double fields =
      density.reader ? stored_leaf * double(density.leaves.size()) : double(value_bytes(density));
  return std::max(limit - fields, limit / 2);
}

}  // namespace

std::optional<Regions> needed_regions(const View& view, const Wish& wish,
                                      std::optional<double> given_limit) {
  const Medium& medium = view.medium;
  const bool in_file = medium.density->reader != nullptr;
  const bool must = given_limit || view.scene.memory_limit > 0 || in_file;
  const double limit =
      given_limit ? *given_limit : left_beside_fields(view, double(grid_memory(view.scene)));
  // light is a grid over the density's bricks
  const int light = medium.light ? LitLuminance(view, light_beams(view)).channels() : 0;
  double most = (1 + light) * most_bytes(*medium.density);
  for (const auto& field : {medium.luminance, medium.emission, medium.gradient})
    if (field) most += most_bytes(*field);
  if (!in_file && (limit == 0 || most <= limit)) return {};

  const Needs needs = needs_of(view, light);
  if (!in_file && needs.whole() <= limit) return {};
  const std::string obstacle = region_obstacle(view, wish);
  if (!obstacle.empty() && !must) return {};
  double count = needs.bricks;
  while (count >= 1 && needs.of_part(count) > limit) count *= 0.95;
  if (obstacle.empty() && count >= 1) {
    auto bricks = in_file ? leaf_bricks(*medium.density)
                          : textured_bricks(*medium.density, density_options(view));
    return Regions(std::move(bricks), std::size_t(count));
  }
  std::string why = "; --texel float16 halves it";
  if (!obstacle.empty()) why += ", and only " + obstacle + " are drawn in parts";
  throw Error(ExitCode::memory, "grid '" + medium.density->name + "' needs an atlas of " +
                                    mebibytes(std::uint64_t(needs.whole())) +
                                    " (host and GPU), over the limit of " +
                                    mebibytes(std::uint64_t(limit)) + why);
}

LightDepths RegionMarcher::light_depths(const View& view) {
  return [this, &view](const Beam& beam, const LightBlocks& blocks, const TakeDepths& take,
                       const Progress& progress) {
    std::vector<double> sums(512 * blocks.wanted.size());
    std::vector<std::size_t> rows(blocks.all.size());
    for (std::size_t i = 0; i < blocks.wanted.size(); ++i) rows[blocks.wanted[i]] = 512 * i;
    const TakeDepths add = [&](std::size_t block, std::span<const double> depths) {
      double* sum = sums.data() + rows[block];
      for (std::size_t i = 0; i < depths.size(); ++i) sum[i] += depths[i];
    };
    const auto boxes = regions_.boxes();
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const MediumAtlas atlas = build_region_atlas(view, boxes[i]);
      marcher_.upload(atlas, Filter::exact);
      Progress part;
      if (progress)
        part = [&](double fraction) { progress((double(i) + fraction) / double(boxes.size())); };
      marcher_.light_depths(view)(beam, blocks, add, part);
    }
    marcher_.holds = 0;
    for (const std::size_t block : blocks.wanted)
      take(block, std::span<const double>(sums).subspan(rows[block], 512));
  };
}

RenderResult RegionMarcher::render(const View& view, const RenderOptions& options) {
  give_back_freed_memory();
  View one = view.scene.tolerance ? with_method(view, exact_method(view)) : view;
  one.scene.pixel_samples = 1;
  const int samples = view.scene.pixel_samples;
  const glm::ivec2 size = view.scene.resolution;
  const auto boxes = regions_.front_to_back(view.camera, view.medium.density->world_from_index);
  RenderOptions part = options;
  part.transmittance = true;
  part.tile = {};
  double done = 0;
  const double share = 1.0 / double(boxes.size() * std::size_t(samples));
  if (options.progress)
    part.progress = [&](double fraction) { options.progress(share * (done + fraction)); };
  Rays rays(size, samples);
  RenderResult result;
  result.stats.renderer = marcher_.description();
  for (const Box& box : boxes) {
    const PixelBox pixels = pixels_of(view, box);
    if (pixels.empty()) {
      done += samples;
      continue;
    }
    part.pixels = pixels;
    const MediumAtlas atlas = build_region_atlas(view, box);
    marcher_.upload(atlas, view.scene.filter);
    for (int sample = 0; sample < samples; ++sample, ++done) {
      part.place = pixel_sample(sample, samples);
      const RenderResult drawn = marcher_.render(one, part);
      rays.add(drawn.image, pixels.origin, std::size_t(sample));
      add_counts(drawn.stats, result.stats);
    }
  }
  marcher_.holds = 0;
  result.stats.rays = std::uint64_t(size.x) * std::uint64_t(size.y) * std::uint64_t(samples);
  result.image = rays.picture(size, options.transmittance);
  return result;
}

}  // namespace psivox
