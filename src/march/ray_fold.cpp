#include "march/ray_fold.h"

#include <algorithm>
#include <cmath>

#include "march/atlas_march.h"

namespace psivox {

/// The march without an atlas, for what it shows of maxima.
struct RayFold::Maxima {
  explicit Maxima(const View& view) : setup(make_march_setup(view, none)), march(setup, none) {}

  glm::dvec4 picture(double value) {
    glsl::AtlasMarch::March ray{};
    ray.radiance.x = value;
    return march.picture(ray, {}, {});
  }

  const MediumAtlas none{};
  const MarchSetup setup;
  glsl::AtlasMarch march;
};

RayFold::RayFold(const View& view) : shows_(info(view.scene.mode).shows) {
  if (shows_ == Shows::value) maxima_ = std::make_shared<Maxima>(view);
}

glm::dvec4 RayFold::nothing() const {
  return maxima_ ? glm::dvec4(maxima_->march.UNKNOWN, 0, 0, 0) : glm::dvec4(0, 0, 0, 1);
}

void RayFold::add_behind(glm::dvec4& ray, const glm::dvec4& behind) const {
  if (maxima_) {
    const bool found = ray.y > 0;
    if (!found) ray = {std::max(ray.x, behind.x), behind.y, 0, 0};
    return;
  }
  const double weight = shows_ == Shows::depth ? 1 : ray.a;
  for (int c = 0; c < 3; ++c) ray[c] += weight * behind[c];
  ray.a *= behind.a;
}

float RayFold::depth(const glm::dvec4& ray, float own, const glm::dvec4& behind,
                     float others) const {
  if (maxima_) return ray.y == 0 && behind.x > ray.x ? others : own;
  return std::isfinite(own) ? own : others;
}

bool RayFold::ended(const glm::dvec4& ray, double least) const {
  if (maxima_) return ray.y > 0;
  return shows_ != Shows::depth && ray.a <= least;
}

glm::dvec4 RayFold::picture(const glm::dvec4& ray) const {
  if (maxima_) return maxima_->picture(ray.x);
  return {glm::dvec3(ray), 1 - ray.a};
}

double RayFold::transmittance(const glm::dvec4& ray) const {
  return maxima_ || shows_ == Shows::surface ? 1 : ray.a;
}

}  // namespace psivox
