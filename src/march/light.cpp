#include "march/light.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/ext/scalar_constants.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <optional>

#include "base/memory.h"
#include "base/text.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "march/medium_atlas.h"
#include "medium/luminance_sources.h"
#include "psivox/parameters.h"
#include "scene/environment.h"

namespace psivox {
namespace {

/// The brightest beam's radiance if all others are fractions of it, else nothing.
std::optional<glm::dvec3> common_color(std::span<const Beam> beams) {
  glm::dvec3 color(0);
  for (const Beam& beam : beams)
    if (glm::dot(beam.radiance, beam.radiance) > glm::dot(color, color)) color = beam.radiance;
  for (const Beam& beam : beams)
    if (glm::cross(beam.radiance, color) != glm::dvec3(0)) return {};
  return color;
}

/// Whether the colours of the medium's function are left to rays.
bool leaves_colors(const Medium& medium) { return medium.source == LuminanceSource::transfer; }

/// The colour of all of a medium's light from some beams, and of what it adds to them at voxels, if
/// it has one.
std::optional<glm::dvec3> common_color(const Medium& medium, std::span<const Beam> beams) {
  std::vector<Beam> all(beams.begin(), beams.end());
  if (!medium.light->albedo.empty()) return {};
  if (leaves_colors(medium)) {
    all.push_back({.radiance = medium.color});
  } else {
    const bool glows = medium.source != LuminanceSource::constant && medium.color != glm::dvec3(0);
    if (glows || medium.light->tinted) return {};
  }
  return common_color(all);
}

double decayed(double depth) { return std::exp(-depth); }

/// e^-depth of depths from 0 on as 2^n 2^f, f from -1/2 to 1/2, in operations that compilers
/// vectorise. It is off by 1e-7 + 1e-7 depth of itself; below 2^-125 it is 0.
float decayed(float depth) {
  constexpr float to_bits = 1.44269504f,
                  whole = 12582912;  // log2(e); 1.5 2^23: no digits behind it
  const float t = std::max(-to_bits * depth, -126.0f), n = t + whole;
  const float x = (t - (n - whole)) * 0.693147181f;  // ln(2) f
  float series = 1;
  for (const float k : {7.0f, 6.0f, 5.0f, 4.0f, 3.0f, 2.0f, 1.0f})
    series = 1 + series * (x * (1 / k));
  const float power = std::bit_cast<float>((std::bit_cast<std::uint32_t>(n) + 127) << 23);
  return t > -125 ? series * power : 0;
}

/// Values at all voxels of some blocks of the density, as a field of its transform.
Field field_of_blocks(const Field& density, LightBlocks blocks, int channels,
                      std::span<float* const> values, Storage storage) {
  Field field;
  field.name = "light";
  field.value_type = channels == 3 ? "vec3s" : "float";
  field.channels = channels;
  // One voxel more: on the faces of the density's domain there is light too.
  field.active_box = {density.active_box.min - 1, density.active_box.max + 1};
  field.active_voxels = 512 * blocks.size();
  field.world_from_index = density.world_from_index;
  for (std::size_t i = 0; i < blocks.size(); ++i) field.leaves.push_back({blocks[i], values[i]});
  field.storage = std::move(storage);
  return field;
}

/// An octave's light, optical depth and mean cosine, as parts of those of the one before. These are
/// the paper's a, b and c; its light may not exceed its extinction (a <= b).
constexpr double octave_ratio = 0.5;

}  // namespace

View seen_from(const View& view, std::size_t volume) {
  View own = view;
  if (volume == 0) return own;
  const std::size_t other = volume - 1;
  own.medium = view.medium.others[other];
  own.medium.others = view.medium.others;
  own.medium.others[other] = view.medium;
  own.medium.others[other].others.clear();
  if (other < view.scene.volumes.size())
    own.scene.albedo = scene_of_volume(view.scene, view.scene.volumes[other]).albedo;
  return own;
}

bool is_to_be_lit(const View& dark, std::size_t volume) {
  const Medium& medium = volume == 0 ? dark.medium : dark.medium.others[volume - 1];
  return medium.light.has_value();
}

std::vector<Beam> beams_on(const View& seen, std::size_t volume, std::span<const Beam> beams) {
  if (volume == 0) return {beams.begin(), beams.end()};
  std::vector<Beam> own = light_beams(seen);
  const std::size_t lights = own.size();
  if (beams.size() > lights)
    for (const Beam& beam : sky_beams(seen, int(beams.size() - lights))) own.push_back(beam);
  for (std::size_t b = 0; b < own.size(); ++b)
    own[b].method = (b < lights ? beams[b] : beams.back()).method;
  // of the picture's camera, whatever that of `seen` is
  for (std::size_t b = 0; b < lights; ++b) own[b].direction = beams[b].direction;
  return own;
}

std::shared_ptr<const TransferFunction> without_colors(const Medium& medium) {
  if (!medium.transfer) return nullptr;
  return std::make_shared<const TransferFunction>(medium.transfer->attenuation_alone());
}

std::string light_method_text(const LightMethod& method) {
  if (method.spacing > 0)
    return formatted("columns %.4g voxel%s apart", method.spacing, method.spacing == 1 ? "" : "s");
  if (method.termination > 0)
    return formatted("a ray from each voxel, down to a transmittance of %.2g", method.termination);
  return "a ray from each voxel";
}

std::vector<Beam> light_beams(const View& view) {
  std::vector<Beam> beams;
  for (const ParallelLight& light : view.medium.light->lights)
    beams.push_back({light.of_camera ? from_camera(view.camera, light.direction) : light.direction,
                     light.radiance});
  return beams;
}

std::vector<Beam> sky_beams(const glm::dvec3& radiance, int count) {
  std::vector<Beam> beams;
  const double golden = (std::sqrt(5.0) - 1) / 2;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1) / double(count);
    const double r = std::sqrt(1 - z * z);
    const double turn = 2 * glm::pi<double>() * (i * golden - std::floor(i * golden));
    beams.push_back({{r * std::cos(turn), z, r * std::sin(turn)}, radiance / double(count)});
  }
  return beams;
}

std::vector<Beam> sky_beams(const View& view, int count) {
  const Environment* const map = view.environment.get();
  const glm::dvec3 albedo = view.scene.albedo;
  const glm::dvec3 radiance =
      map && map->constant() ? *map->constant() * albedo : view.medium.light->sky;
  if (!map || map->constant())
    return radiance == glm::dvec3(0) ? std::vector<Beam>{} : sky_beams(radiance, count);
  std::vector<Beam> beams;
  for (const Environment::Source& source : map->sources(count))
    beams.push_back({-source.towards, source.radiance * albedo});
  return beams;
}

double transmittance_of(double light, int octaves) {
  if (octaves == 1) return light;
  const auto arriving = [&](double depth) {
    double sum = 0, scale = 1;
    for (int i = 0; i < octaves; ++i, scale *= octave_ratio)
      sum += scale * std::exp(-scale * depth);
    return sum;
  };
  double shallow = 0, deep = 1;
  while (arriving(deep) > light) deep *= 2;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (shallow + deep);
    (arriving(middle) > light ? shallow : deep) = middle;
  }
  const double T = std::exp(-deep);
  return T < double(std::numeric_limits<float>::min()) ? 0 : T;  // GPUs have no less
}

LitLuminance::LitLuminance(const View& view, std::vector<Beam> given)
    : medium_(view.medium),
      camera_(view.camera),
      g_(view.scene.phase_g),
      octaves_(view.scene.scatter_octaves),
      beams_(std::move(given)),
      glow_(medium_),
      albedo_(medium_) {
  (medium_.source == LuminanceSource::constant ? ambient_ : own_color_) = medium_.color;
  by_ray_ = g_ != 0 && octaves_ == 1 && beams_.size() == 1 && own_color_ == glm::dvec3(0);
  common_ = common_color(medium_, beams_);
}

double LitLuminance::phase(const Beam& beam, const glm::ivec3& voxel, double cosine) const {
  const glm::dvec3 at(medium_.density->world_from_index * glm::dvec4(voxel, 1));
  const glm::dvec3 seen =
      camera_.orthographic || at == camera_.position ? camera_.forward : at - camera_.position;
  return henyey_greenstein(cosine, -glm::dot(beam.direction, glm::normalize(seen)));
}

template <typename Real>
void LitLuminance::scattered(const Beam& beam, const auto& voxel, std::span<const Real> depths,
                             Real* to) const {
  const bool phases = g_ != 0 && !by_ray_;
  std::fill_n(to, depths.size(), Real(0));
  Real scale = 1;
  for (int octave = 0; octave < octaves_; ++octave, scale *= Real(octave_ratio)) {
    // a lattice's depths may be below 0
    const auto part = [&](std::size_t i) {
      return scale * decayed(scale * std::max(depths[i], Real(0)));
    };
    if (phases)
      for (std::size_t i = 0; i < depths.size(); ++i)
        to[i] += part(i) * Real(phase(beam, voxel(i), g_ * double(scale)));
    else
      for (std::size_t i = 0; i < depths.size(); ++i) to[i] += part(i);
  }
}

glm::dvec3 LitLuminance::share(std::size_t beam, const glm::ivec3& voxel, double depth) const {
  double arriving = 0;
  scattered(
      beams_[beam], [&](std::size_t) { return voxel; }, std::span<const double>(&depth, 1),
      &arriving);
  glm::dvec3 L = beams_[beam].radiance * arriving;
  if (!albedo_.is_one()) L *= albedo_.at(voxel);
  return medium_.light->tinted ? L * glow_.at(voxel) : L;
}

double LitLuminance::brightest() const {
  double arriving = 0, scale = 1;
  for (int octave = 0; octave < octaves_; ++octave, scale *= octave_ratio)
    arriving += scale * henyey_greenstein(std::abs(g_ * scale), 1);
  glm::dvec3 light(0);
  for (const Beam& beam : beams_) light += beam.radiance * arriving;
  const auto& albedo = medium_.light->albedo;
  if (albedo.size() == 1) light *= greatest_value(*albedo.front());  // three give at most 1
  if (medium_.light->tinted) light *= greatest_glow(medium_);
  if (own_color_ != glm::dvec3(0)) light += own_color_ * greatest_glow(medium_);
  light += ambient_;
  return std::max({light.x, light.y, light.z});
}

glm::dvec3 LitLuminance::own(const glm::ivec3& voxel) const {
  return own_color_ == glm::dvec3(0) ? glm::dvec3(0) : own_color_ * glow_.at(voxel);
}

void LitLuminance::add(const Beam& beam, bool first, const glm::ivec3& origin,
                       std::span<const double> depths, float* to) const {
  std::array<float, 512> some, arriving;
  std::ranges::transform(depths, some.begin(), [](double depth) { return float(depth); });
  scattered(
      beam, [&](std::size_t i) { return origin + leaf_voxel(int(i)); },
      std::span<const float>(some), arriving.data());
  if (common_) {
    const double all = glm::length(*common_);
    const auto part = [&](const glm::dvec3& of) { return float(glm::length(of) / all); };
    const float ratio = all > 0 ? part(beam.radiance) : 1;
    if (first) std::fill_n(to, 512, all > 0 ? part(own_color_) : 0);
    for (std::size_t i = 0; i < 512; ++i) to[i] += ratio * arriving[i];
    return;
  }
  const bool tinted = medium_.light->tinted, glows = first && own_color_ != glm::dvec3(0);
  for (int i = 0; i < 512; ++i, to += 3) {
    const glm::dvec3 own_glow = tinted || glows ? glow_.at(origin + leaf_voxel(i)) : glm::dvec3(1);
    glm::dvec3 L = beam.radiance * double(arriving[std::size_t(i)]);
    if (!albedo_.is_one()) L *= albedo_.at(origin + leaf_voxel(i));
    if (tinted) L *= own_glow;
    if (glows) L += own_color_ * own_glow;
    if (!first) L += glm::dvec3(to[0], to[1], to[2]);
    for (int c = 0; c < 3; ++c) to[c] = float(L[c]);
  }
}

int luminance_channels(const Medium& medium, std::span<const Beam> beams) {
  return common_color(medium, beams) ? 1 : 3;
}

Medium LitLuminance::medium(LightBlocks blocks, const LightDepths& depths,
                            const Progress& progress) const {
  const int channels = this->channels();
  const std::size_t stride = 512 * std::size_t(channels);
  Storage storage({}, 2048);  // pieces of 4 MiB of scalars
  std::vector<float*> places;
  while (places.size() < blocks.size()) {
    const std::size_t count = std::min(storage.leaves, blocks.size() - places.size());
    const std::shared_ptr<float[]> values = page_array<float>(count * stride);
    for (std::size_t i = 0; i < count; ++i) places.push_back(values.get() + i * stride);
    storage.blocks.push_back(values);
  }

  std::vector<std::uint8_t> begun(blocks.size());
  depths(
      beams_, blocks,
      [&](std::size_t beam, std::size_t block, std::span<const double> part) {
        add(beams_[beam], !begun[block], blocks[block], part, places[block]);
        begun[block] = 1;
      },
      progress);

  Medium medium = medium_;
  medium.luminance = std::make_shared<const Field>(
      field_of_blocks(*medium.density, blocks, channels, places, std::move(storage)));
  medium.source = channels == 3 ? LuminanceSource::vector : LuminanceSource::scalar;
  medium.color = common_.value_or(glm::dvec3(1));
  medium.ambient = ambient_;
  medium.lit_colors = leaves_colors(medium_);
  if (!medium.lit_colors) medium.transfer = without_colors(medium);
  if (by_ray_) {
    medium.phase_axis = beams_.front().direction;
    medium.phase_g = g_;
  }
  medium.light.reset();
  medium.lit = true;
  medium.brightest = brightest();
  return medium;
}

Medium lit_medium(const View& dark, const std::vector<Beam>& beams, LightBlocks blocks,
                  const DepthsAt& depths_at, const Progress& progress) {
  const double share = 1 / double(1 + dark.medium.others.size());
  Medium lit = LitLuminance(dark, beams).medium(blocks, depths_at(0), part_of(progress, 0, share));
  for (std::size_t volume = 1; volume <= dark.medium.others.size(); ++volume) {
    if (!is_to_be_lit(dark, volume)) continue;
    const View view = seen_from(dark, volume);
    Medium& other = lit.others[volume - 1];
    other = LitLuminance(view, beams_on(view, volume, beams))
                .medium(visible_blocks(*view.medium.density, density_options(view)),
                        depths_at(volume), part_of(progress, share * double(volume), share));
    other.others.clear();
  }
  return lit;
}

View lit(View view, const DepthsAt& depths_at, const Progress& progress, const WantBlock& wanted) {
  if (!view.medium.light) return view;
  std::vector<Beam> beams = light_beams(view);
  for (const Beam& beam : sky_beams(view, exact_sky_count)) beams.push_back(beam);
  auto blocks = visible_blocks(*view.medium.density, density_options(view));
  if (wanted) std::erase_if(blocks, [&](const glm::ivec3& block) { return !wanted(block); });
  view.medium = lit_medium(view, beams, blocks, depths_at, progress);
  return view;
}

View lit(View view, const LightDepths& depths, const Progress& progress) {
  return lit(
      std::move(view), [&](std::size_t) { return depths; }, progress);
}

View depth_march(const View& view, double termination) {
  View march = view;
  march.holdout.reset();
  Scene& scene = march.scene;
  scene.mode = Mode::alpha;
  scene.sampling = Sampling::cells;
  scene.step.reset();
  scene.integrator = Integrator::psi_weighted;
  // between knots of values the attenuation is a cubic, whose depth is exact
  scene.split_knots = !view.medium.gradient;
  if (scene.split_knots)
    scene.segments = 1;
  else if (scene.tolerance)
    scene.segments = gradient_segments;
  scene.early_termination = termination;
  scene.filter = Filter::exact;
  scene.pixel_samples = 1;
  Medium& medium = march.medium;
  medium.source = LuminanceSource::constant;
  medium.transfer = without_colors(medium);
  medium.luminance.reset();
  medium.emission.clear();
  medium.light.reset();
  medium.others.clear();
  return march;
}

View light_march(const View& view, const Beam& beam) {
  View towards = depth_march(view, beam.method.termination);
  Camera& camera = towards.camera;
  camera = {};
  camera.forward = -beam.direction;
  camera.orthographic = true;
  return towards;
}

}  // namespace psivox
