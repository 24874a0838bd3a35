#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "psivox/image.h"

namespace psivox {

/// What a ray has collected up to a depth. Between points of a curve, optical depth and radiance
/// are linear.
struct CurvePoint {
  double z = 0;      ///< along the view, from the camera [world units]
  double depth = 0;  ///< optical depth
  glm::dvec3 radiance{0};
};
using RayCurve = std::vector<CurvePoint>;

/// The curve of a pixel: means of transmittance and radiance over its rays.
RayCurve mean_curve(const std::vector<RayCurve>& rays);

/// Adds samples, front to back, whose transmittance and radiance up to every point of the curve are
/// within `tolerance` of it, few of them: each reaches as far as a sample can. Their errors do not
/// add up.
void fit_samples(const RayCurve& curve, double tolerance, std::vector<DeepSample>& samples);

/// R G B A of samples that lie one behind the other.
glm::vec4 flattened(const DeepSample* samples, std::size_t count);

}  // namespace psivox
