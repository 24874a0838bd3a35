#include "march/march_double.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <optional>

namespace psivox {
namespace {

/// Numbers that a quantity may have.
struct Window {
  double low = -HUGE_VAL, high = HUGE_VAL;
  bool empty() const { return low > high; }
  double middle() const { return 0.5 * (low + high); }
  void narrow(double a, double b) {
    low = std::max(low, a);
    high = std::min(high, b);
  }
};

/// A sample under way: what is collected in front of it, and what it adds up to the point `last`.
struct Reach {
  std::size_t first = 0, last = 0;
  double depth = 0;        ///< optical depth of the sample
  glm::dvec3 radiance{0};  ///< of the sample, as seen at its front
};

/// Fits samples to a curve, greedily from the front. A sample's optical depth grows linearly and
/// its radiance with its opacity ("Interpreting OpenEXR Deep Pixels", Kainz 2013). At its end a
/// sample may be off by the tolerance, as in Lokovic and Veach's deep shadow maps (2000). It then
/// reaches farther than one whose ends must lie on the curve.
class Fit {
 public:
  Fit(const RayCurve& curve, double tolerance) : curve_(curve), tolerance_(tolerance) {
    for (const CurvePoint& point : curve) {
      const double T = std::exp(-point.depth);
      depths_.push_back(
          {-std::log(T + tolerance), T > tolerance ? -std::log(T - tolerance) : HUGE_VAL});
    }
  }

  void add_to(std::vector<DeepSample>& samples) {
    std::size_t at = 0;
    while (at + 1 < curve_.size()) {
      const std::size_t later = end_of_gap(at);
      if (later + 1 >= curve_.size()) return;
      Reach best = reach_from(at);
      if (later > at)
        if (const Reach other = reach_from(later); other.last > best.last) best = other;
      at = best.last;
      const DeepSample sample = sample_of(best);
      if (sample.r == 0 && sample.g == 0 && sample.b == 0 && sample.a == 0) continue;
      samples.push_back(sample);
      radiance_ += std::exp(-depth_) * glm::dvec3(sample.r, sample.g, sample.b);
      depth_ -= std::log1p(-double(sample.a));
    }
  }

 private:
  /// The last point up to which nothing need be added, with half of the tolerance left for the
  /// sample that follows; all of it at the curve's end.
  std::size_t end_of_gap(std::size_t first) const {
    const double T = std::exp(-depth_);
    std::size_t last = first;
    for (std::size_t i = first; i < curve_.size(); ++i) {
      const glm::dvec3 miss = glm::abs(curve_[i].radiance - radiance_);
      const double most =
          std::max({std::abs(std::exp(-curve_[i].depth) - T), miss.x, miss.y, miss.z});
      if (most > tolerance_) return last;
      if (most <= 0.5 * tolerance_ && last + 1 >= i) last = i;
      if (i + 1 == curve_.size()) last = i;
    }
    return last;
  }

  /// Optical depths a unit of z that keep the transmittance up to each point within the tolerance.
  Window slopes(std::size_t first, std::size_t last) const {
    Window window{0, HUGE_VAL};
    for (std::size_t i = first + 1; i <= last && !window.empty(); ++i) {
      const double z = curve_[i].z - curve_[first].z;
      window.narrow((depths_[i].low - depth_) / z, (depths_[i].high - depth_) / z);
    }
    return window;
  }

  /// The sample's radiance, if that of every point is within the tolerance. A curve never falls:
  /// where the samples in front are above it, none need take light away.
  std::optional<glm::dvec3> radiance_of(std::size_t first, std::size_t last, double depth) const {
    const double T = std::exp(-depth_), length = curve_[last].z - curve_[first].z;
    Window windows[3];
    for (std::size_t i = first + 1; i <= last; ++i) {
      const double x = (curve_[i].z - curve_[first].z) / length;
      const double share = depth > 1e-30 ? std::expm1(-x * depth) / std::expm1(-depth) : x;
      for (int c = 0; c < 3; ++c) {
        const double missing = curve_[i].radiance[c] - radiance_[c];
        windows[c].narrow((missing - tolerance_) / (T * share),
                          (missing + tolerance_) / (T * share));
        if (windows[c].empty()) return {};
      }
    }
    glm::dvec3 radiance;
    for (int c = 0; c < 3; ++c) radiance[c] = std::max(windows[c].middle(), 0.0);
    return radiance;
  }

  std::optional<Reach> sample_to(std::size_t first, std::size_t last) const {
    Window window = slopes(first, last);
    if (window.empty()) return {};
    const double length = curve_[last].z - curve_[first].z;
    window.high = std::min(window.high, std::max(window.low, most_depth / length));
    if (curve_[last].depth == curve_[first].depth) window.high = window.low;  // glow alone
    const double own = std::clamp((curve_[last].depth - depth_) / length, window.low, window.high);
    for (const double slope : {window.middle(), own}) {
      const double depth = length * slope;
      if (const auto radiance = radiance_of(first, last, depth))
        return Reach{first, last, depth, *radiance};
    }
    return {};
  }

  Reach reach_from(std::size_t first) const {
    // to the next point a sample always leads: the curve itself, whatever is missing in front
    const CurvePoint& next = curve_[first + 1];
    const double T = std::exp(-depth_);
    Reach best{first, first + 1, std::clamp(next.depth - depth_, 0.0, most_depth),
               glm::max(next.radiance - radiance_, glm::dvec3(0)) / T};
    if (const auto near = sample_to(first, first + 1)) best = *near;
    std::size_t step = 1, end = curve_.size() - 1;
    while (best.last < end) {  // twice as far each time, then between
      const std::size_t last = std::min(best.last + step, end);
      if (const auto further = sample_to(first, last)) {
        best = *further;
        step *= 2;
      } else {
        end = last - 1;
        step = std::max<std::size_t>((end - std::min(best.last, end) + 1) / 2, 1);
      }
    }
    return best;
  }

  /// Its numbers are rounded as far as a sixteenth of the tolerance allows, so that they take fewer
  /// bytes in a file. The samples behind make up for it.
  DeepSample sample_of(const Reach& reach) const {
    const double step = std::exp2(std::floor(std::log2(tolerance_ / 8 * std::exp(depth_))));
    const auto rounded = [&](double value) { return float(std::round(value / step) * step); };
    const double a = -std::expm1(-reach.depth);
    return {float(curve_[reach.first].z), float(curve_[reach.last].z),
            rounded(reach.radiance.x),    rounded(reach.radiance.y),
            rounded(reach.radiance.z),    a < 0.5 ? rounded(a) : float(a)};
  }

  /// An opacity of 1 would be at the sample's front; float32 holds 1 - 1e-6.
  static constexpr double most_depth = 13.8;

  const RayCurve& curve_;
  double tolerance_;
  std::vector<Window> depths_;  ///< optical depths within the tolerance at each point
  double depth_ = 0;            ///< what the samples so far add up to
  glm::dvec3 radiance_{0};
};

/// A curve at rising depths.
class Follow {
 public:
  explicit Follow(const RayCurve& curve) : curve_(&curve) {}
  CurvePoint at(double z) {
    const RayCurve& curve = *curve_;
    while (next_ < curve.size() && curve[next_].z < z) ++next_;
    if (next_ == 0) return {z, 0, {}};
    const CurvePoint& before = curve[next_ - 1];
    if (next_ == curve.size()) return before;
    const CurvePoint& after = curve[next_];
    const double x = (z - before.z) / (after.z - before.z);
    return {z, std::lerp(before.depth, after.depth, x),
            glm::mix(before.radiance, after.radiance, x)};
  }

 private:
  const RayCurve* curve_;
  std::size_t next_ = 0;
};

}  // namespace

RayCurve mean_curve(const std::vector<RayCurve>& rays) {
  if (rays.size() == 1) return rays.front();
  std::vector<double> places;
  std::vector<Follow> follows;
  for (const RayCurve& ray : rays) {
    for (const CurvePoint& point : ray) places.push_back(point.z);
    follows.emplace_back(ray);
  }
  std::ranges::sort(places);
  places.erase(std::unique(places.begin(), places.end()), places.end());
  RayCurve mean;
  for (const double z : places) {
    double T = 0;
    glm::dvec3 radiance(0);
    for (Follow& follow : follows) {
      const CurvePoint point = follow.at(z);
      T += std::exp(-point.depth) / double(rays.size());
      radiance += point.radiance / double(rays.size());
    }
    mean.push_back({z, -std::log(T), radiance});
  }
  return mean;
}

void fit_samples(const RayCurve& curve, double tolerance, std::vector<DeepSample>& samples) {
  Fit(curve, tolerance * 15 / 16).add_to(samples);  // the rest is for rounding
}

glm::vec4 flattened(const DeepSample* samples, std::size_t count) {
  glm::dvec3 radiance(0);
  double T = 1;
  for (const DeepSample* s = samples; s != samples + count; ++s) {
    radiance += T * glm::dvec3(s->r, s->g, s->b);
    T *= 1 - double(s->a);
  }
  return {radiance, 1 - T};
}

}  // namespace psivox
