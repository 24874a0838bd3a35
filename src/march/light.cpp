#include "march/light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/ext/scalar_constants.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <numeric>
#include <optional>

#include "field/field_index.h"
#include "march/medium_atlas.h"
#include "psivox/text.h"

namespace psivox {
namespace {

/// Blocks whose exact depths are asked for at once, between two reports of progress.
constexpr std::size_t batch = 512;

}  // namespace

/// The colours of a transfer function, for many values: its intervals are found by bins, several to
/// an interval.
class FunctionColors {
 public:
  explicit FunctionColors(const TransferFunction& function) {
    const std::vector<TransferPoint>& points = function.points();
    first_ = points.front().value;
    last_ = points.back().value;
    for (std::size_t k = 0; k + 1 < points.size(); ++k)
      intervals_.push_back(
          {points[k].value, points[k + 1].value, points[k].color,
           (points[k + 1].color - points[k].color) / (points[k + 1].value - points[k].value)});
    if (intervals_.empty()) intervals_.push_back({first_, HUGE_VAL, points[0].color, {}});
    const auto bins = 4 * intervals_.size();
    scale_ = last_ > first_ ? double(bins) / (last_ - first_) : 0;
    for (std::size_t bin = 0; bin < bins; ++bin) {
      // a bin earlier than it begins, whatever rounding does
      const double from = scale_ > 0 ? first_ + (double(bin) - 1) / scale_ : first_;
      begins_.push_back(
          std::size_t(std::clamp(function.interval(from), 0, int(intervals_.size()) - 1)));
    }
  }

  glm::dvec3 at(float value) const {
    const double v = std::clamp(double(value), first_, last_);
    const auto bin = std::min(std::size_t((v - first_) * scale_), begins_.size() - 1);
    const Interval* in = &intervals_[begins_[bin]];
    while (v > in->end) ++in;
    return in->color + in->slope * (v - in->begin);
  }

 private:
  struct Interval {
    double begin, end;
    glm::dvec3 color, slope;
  };
  std::vector<Interval> intervals_;
  std::vector<std::size_t> begins_;  ///< of each bin, an interval that is not behind it
  double first_ = 0, last_ = 0, scale_ = 0;
};

/// The luminance of the medium before its light and without `color`, at voxels of the density.
class OwnLuminance {
 public:
  explicit OwnLuminance(const Medium& medium) : medium_(medium) {
    if (medium.transfer || medium.source == LuminanceSource::density)
      index_.emplace(*medium.density);
    if (medium.source == LuminanceSource::transfer) colors_.emplace(*medium.transfer);
    if (medium.luminance) {
      index_.emplace(*medium.luminance);
      to_luminance_ =
          glm::inverse(medium.luminance->world_from_index) * medium.density->world_from_index;
    }
  }

  /// At the 8^3 voxels from `origin` on, z fastest.
  void block(const glm::ivec3& origin, std::span<glm::dvec3> to) const {
    if (medium_.source != LuminanceSource::transfer) {
      for (int i = 0; i < 512; ++i)
        to[std::size_t(i)] = at(origin + glm::ivec3(i >> 6, (i >> 3) & 7, i & 7));
      return;
    }
    const FieldIndex::Block block = index_->block(origin);
    for (int i = 0; i < 512; ++i) to[std::size_t(i)] = colors_->at(block.value(i));
  }

  glm::dvec3 at(const glm::ivec3& voxel) const {
    switch (medium_.source) {
      case LuminanceSource::constant:
        break;
      case LuminanceSource::density:
        return glm::dvec3(index_->at(voxel).x);
      case LuminanceSource::transfer:
        return colors_->at(float(index_->at(voxel).x));
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
  std::optional<FunctionColors> colors_;
  glm::dmat4 to_luminance_{1};
};

/// The factor of the albedo at voxels of the density.
class PointAlbedo {
 public:
  explicit PointAlbedo(const Medium& medium) {
    if (!medium.light) return;
    for (const auto& field : medium.light->albedo)
      grids_.push_back({FieldIndex(*field), field->channels,
                        glm::inverse(field->world_from_index) * medium.density->world_from_index});
    if (grids_.size() == 3) density_.emplace(*medium.density);
  }

  bool is_one() const { return grids_.empty(); }

  glm::dvec3 at(const glm::ivec3& voxel) const {
    if (!density_) {
      const glm::dvec3 value = sample(grids_.front(), voxel);
      return grids_.front().channels == 1 ? glm::dvec3(value.x) : value;
    }
    // Colour times density. Where there is none, the mean colour beside it, so that the light
    // that is interpolated towards there keeps its colour.
    glm::dvec4 sum = colored(voxel);
    if (!(sum.w > 0))
      for (int i = 0; i < 27; ++i) sum += colored(voxel + glm::ivec3(i / 9, i / 3 % 3, i % 3) - 1);
    return sum.w > 0 ? glm::min(glm::dvec3(sum) / sum.w, 1.0) : glm::dvec3(0);
  }

 private:
  struct Grid {
    FieldIndex index;
    int channels;
    glm::dmat4 from_voxel;
  };

  static glm::dvec3 sample(const Grid& grid, const glm::ivec3& voxel) {
    if (grid.from_voxel == glm::dmat4(1)) return grid.index.at(voxel);
    return grid.index.at(glm::dvec3(grid.from_voxel * glm::dvec4(voxel, 1)));
  }

  glm::dvec4 colored(const glm::ivec3& voxel) const {
    glm::dvec4 value(0, 0, 0, std::max(density_->at(voxel).x, 0.0));
    for (int c = 0; value.w > 0 && c < 3; ++c) value[c] = sample(grids_[std::size_t(c)], voxel).x;
    return value;
  }

  std::vector<Grid> grids_;
  std::optional<FieldIndex> density_;  ///< if there are three grids
};

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

/// The colour of all of a medium's luminance in the light of some beams, if it has one.
std::optional<glm::dvec3> common_color(const Medium& medium, std::span<const Beam> beams) {
  const bool glows = medium.source != LuminanceSource::constant && medium.color != glm::dvec3(0);
  if (glows || medium.light->tinted || !medium.light->albedo.empty()) return {};
  return common_color(beams);
}

/// Values at all voxels of some blocks of the density, as a field of its transform.
Field field_of_blocks(const Field& density, const LightBlocks& blocks, int channels,
                      std::shared_ptr<float[]> values) {
  Field field;
  field.name = "light";
  field.value_type = channels == 3 ? "vec3s" : "float";
  field.channels = channels;
  // One voxel more: on the faces of the density's domain there is light too.
  field.active_box = {density.active_box.min - 1, density.active_box.max + 1};
  field.active_voxels = 512 * blocks.wanted.size();
  field.world_from_index = density.world_from_index;
  for (std::size_t i = 0; i < blocks.wanted.size(); ++i)
    field.leaves.push_back({blocks.all[blocks.wanted[i]],
                            values.get() + i * 512 * static_cast<std::size_t>(channels)});
  field.storage = std::move(values);
  return field;
}

}  // namespace

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

namespace {

/// An octave's light, optical depth and mean cosine, as parts of those of the one before. These are
/// the paper's a, b and c; its light may not exceed its extinction (a <= b).
constexpr double octave_ratio = 0.5;

}  // namespace

struct LitLuminance::Impl {
  Impl(const View& view, std::vector<Beam> given)
      : medium(view.medium),
        camera(view.camera),
        g(view.scene.phase_g),
        octaves(view.scene.scatter_octaves),
        beams(std::move(given)),
        glow(medium),
        albedo(medium) {
    (medium.source == LuminanceSource::constant ? ambient : own_color) = medium.color;
    by_ray = g != 0 && octaves == 1 && beams.size() == 1 && own_color == glm::dvec3(0);
    common = common_color(medium, beams);
  }

  double phase(const Beam& beam, const glm::ivec3& voxel, double cosine) const {
    const glm::dvec3 at(medium.density->world_from_index * glm::dvec4(voxel, 1));
    const glm::dvec3 seen =
        camera.orthographic || at == camera.position ? camera.forward : at - camera.position;
    return henyey_greenstein(cosine, -glm::dot(beam.direction, glm::normalize(seen)));
  }

  /// What arrives of a beam's light at a voxel, times its phase: the sum over the octaves. Colour
  /// is float or dvec3, Real the precision of the exponential.
  template <typename Colour, typename Real>
  Colour scattered(const Colour& light, const Beam& beam, const glm::ivec3& voxel,
                   Real depth) const {
    const bool phases = g != 0 && !by_ray;
    depth = std::max(depth, Real(0));  // a lattice's may be below 0
    Colour sum(0);
    Real scale = 1;
    for (int i = 0; i < octaves; ++i, scale *= Real(octave_ratio)) {
      const Colour L = scale * light * std::exp(-scale * depth);
      sum += phases ? Colour(phase(beam, voxel, g * scale) * double_of(L)) : L;
    }
    return sum;
  }
  static double double_of(float value) { return value; }
  static const glm::dvec3& double_of(const glm::dvec3& value) { return value; }

  glm::dvec3 share(const Beam& beam, const glm::ivec3& voxel, double depth) const {
    glm::dvec3 L = scattered(beam.radiance, beam, voxel, depth);
    if (!albedo.is_one()) L *= albedo.at(voxel);
    return medium.light->tinted ? L * glow.at(voxel) : L;
  }

  glm::dvec3 own(const glm::ivec3& voxel) const {
    return own_color == glm::dvec3(0) ? glm::dvec3(0) : own_color * glow.at(voxel);
  }

  /// Adds a beam to a block's values, which the first that comes sets.
  void add(const Beam& beam, bool first, const glm::ivec3& origin, std::span<const double> depths,
           float* to) const {
    const auto voxel = [&](int i) { return origin + glm::ivec3(i >> 6, (i >> 3) & 7, i & 7); };
    if (common) {
      const double all = glm::length(*common);
      const float ratio = all > 0 ? float(glm::length(beam.radiance) / all) : 1;
      for (int i = 0; i < 512; ++i) {
        const float L = scattered(ratio, beam, voxel(i), float(depths[std::size_t(i)]));
        to[i] = first ? L : to[i] + L;
      }
      return;
    }
    const bool tinted = medium.light->tinted, glows = first && own_color != glm::dvec3(0);
    std::array<glm::dvec3, 512> glow_of;
    if (tinted || glows) glow.block(origin, glow_of);
    for (int i = 0; i < 512; ++i, to += 3) {
      const glm::dvec3& own_glow = glow_of[std::size_t(i)];
      glm::dvec3 L = scattered(beam.radiance, beam, voxel(i), depths[std::size_t(i)]);
      if (!albedo.is_one()) L *= albedo.at(voxel(i));
      if (tinted) L *= own_glow;
      if (glows) L += own_color * own_glow;
      if (!first) L += glm::dvec3(to[0], to[1], to[2]);
      for (int c = 0; c < 3; ++c) to[c] = float(L[c]);
    }
  }

  const Medium& medium;
  Camera camera;
  double g;
  int octaves;
  std::vector<Beam> beams;
  OwnLuminance glow;
  PointAlbedo albedo;
  glm::dvec3 ambient{0};             ///< the medium's luminance where it is constant
  glm::dvec3 own_color{0};           ///< factor of `glow` where it is not
  bool by_ray = false;               ///< the phase is one factor of each ray
  std::optional<glm::dvec3> common;  ///< colour of all luminance: one channel will do
};

int luminance_channels(const Medium& medium, std::span<const Beam> beams) {
  return common_color(medium, beams) ? 1 : 3;
}

LitLuminance::LitLuminance(const View& view, std::vector<Beam> beams)
    : impl_(std::make_unique<Impl>(view, std::move(beams))) {}
LitLuminance::~LitLuminance() = default;

const std::vector<Beam>& LitLuminance::beams() const { return impl_->beams; }

glm::dvec3 LitLuminance::own(const glm::ivec3& voxel) const { return impl_->own(voxel); }

glm::dvec3 LitLuminance::share(std::size_t beam, const glm::ivec3& voxel, double depth) const {
  return impl_->share(impl_->beams[beam], voxel, depth);
}

bool LitLuminance::sees_camera() const { return impl_->g != 0 && !impl_->by_ray; }

int LitLuminance::channels() const { return impl_->common ? 1 : 3; }

Medium LitLuminance::medium(const LightBlocks& blocks, const LightDepths& depths,
                            const Progress& progress) const {
  const Impl& impl = *impl_;
  const int channels = this->channels();
  const std::size_t stride = 512 * std::size_t(channels);
  const auto values = std::make_shared_for_overwrite<float[]>(blocks.wanted.size() * stride);
  std::vector<float*> places(blocks.all.size(), nullptr);
  for (std::size_t i = 0; i < blocks.wanted.size(); ++i)
    places[blocks.wanted[i]] = values.get() + i * stride;

  std::vector<std::uint8_t> begun(blocks.all.size());
  depths(
      impl.beams, blocks,
      [&](std::size_t beam, std::size_t block, std::span<const double> part) {
        impl.add(impl.beams[beam], !begun[block], blocks.all[block], part, places[block]);
        begun[block] = 1;
      },
      progress);

  Medium medium = impl.medium;
  medium.luminance =
      std::make_shared<const Field>(field_of_blocks(*medium.density, blocks, channels, values));
  medium.source = channels == 3 ? LuminanceSource::vector : LuminanceSource::scalar;
  medium.color = impl.common.value_or(glm::dvec3(1));
  medium.ambient = impl.ambient;
  medium.transfer = without_colors(medium);
  if (impl.by_ray) {
    medium.phase_axis = impl.beams.front().direction;
    medium.phase_g = impl.g;
  }
  medium.light.reset();
  medium.lit = true;
  return medium;
}

LightDepths one_by_one(BeamDepths depths) {
  return [depths = std::move(depths)](std::span<const Beam> beams, const LightBlocks& blocks,
                                      const TakeLight& take, const Progress& progress) {
    for (std::size_t b = 0; b < beams.size(); ++b)
      depths(
          beams[b], blocks,
          [&](std::size_t block, std::span<const double> part) { take(b, block, part); },
          [&](double done) {
            if (progress) progress((double(b) + done) / double(beams.size()));
          });
  };
}

void in_batches(const LightBlocks& blocks, const Progress& progress,
                const std::function<void(std::span<const std::size_t>)>& some) {
  const std::span<const std::size_t> wanted = blocks.wanted;
  for (std::size_t first = 0; first < wanted.size(); first += batch) {
    const std::span<const std::size_t> part =
        wanted.subspan(first, std::min(wanted.size() - first, batch));
    some(part);
    if (progress) progress(double(first + part.size()) / double(wanted.size()));
  }
}

View lit(View view, const LightDepths& depths) {
  if (!view.medium.light) return view;
  std::vector<Beam> beams = light_beams(view);
  for (const Beam& beam : sky_beams(view, exact_sky_count)) beams.push_back(beam);
  const std::vector<glm::ivec3> all = visible_blocks(*view.medium.density, density_options(view));
  std::vector<std::size_t> wanted(all.size());
  std::iota(wanted.begin(), wanted.end(), std::size_t{0});
  view.medium = LitLuminance(view, std::move(beams)).medium({all, wanted}, depths);
  return view;
}

View light_march(const View& view, const Beam& beam) {
  View towards = view;
  towards.holdout.reset();
  Scene& scene = towards.scene;
  scene.mode = Mode::alpha;
  scene.sampling = Sampling::cells;
  scene.step.reset();
  scene.integrator = Integrator::psi_weighted;
  // between knots of values the attenuation is a cubic, whose depth is exact
  scene.split_knots = !view.medium.gradient;
  if (scene.split_knots) scene.segments = 1;
  scene.early_termination = beam.method.termination;
  scene.filter = Filter::exact;
  scene.pixel_samples = 1;
  Medium& medium = towards.medium;
  medium.source = LuminanceSource::constant;
  medium.transfer = without_colors(medium);
  medium.luminance.reset();
  medium.emission.reset();
  medium.light.reset();
  Camera& camera = towards.camera;
  camera = {};
  camera.forward = -beam.direction;
  camera.orthographic = true;
  return towards;
}

}  // namespace psivox
