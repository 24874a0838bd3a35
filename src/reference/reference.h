#pragma once

#include <span>
#include <vector>

#include "march/marcher.h"

namespace psivox {

/// Draws the picture in double precision, by another algorithm than the march. Between the faces of
/// trilinear cells and the knots of a transfer function, the attenuation is a cubic. Its Bernstein
/// coefficients give the optical depth exactly. The radiance is integrated by Gauss-Legendre
/// panels, halved until two orders agree within `tolerance` of the ray. No ray ends at a
/// transparency above `tolerance`. The reference reads Field, not the atlas.
///
/// Beside R G B A the image has layer `error`: a bound on the error of each pixel's worst channel;
/// for maxima and surfaces also layer `depth`, the distance from the camera [world units], +Inf
/// where there is none.
RenderResult render_reference(const View& view, double tolerance = 1e-12,
                              const Progress& progress = {});

/// Layer `bound`: at each pixel an upper bound on the difference of the picture's worst channel
/// from the integral of the view's medium along the pixel's rays, before the view's background, as
/// it is seen. It is the difference from the
/// reference, which is off by about `tolerance` at most, plus the reference's own bound, rounded
/// up.
Layer bound_layer(const View& view, const Image& picture, double tolerance = 1e-9,
                  const Progress& progress = {});

/// R G B A of some of the view's pixels, in double.
std::vector<glm::dvec4> reference_pixels(const View& view, std::span<const glm::ivec2> pixels,
                                         double tolerance = 1e-12, const Progress& progress = {});

/// Exact optical depths towards light through the whole medium, whatever a beam's method, from
/// voxels of one of its volumes; 0: the first.
LightDepths reference_light_depths(const View& view, std::size_t volume = 0);
/// The depths from some voxels.
std::vector<double> reference_light_depths(const View& view, const Beam& beam,
                                           std::span<const glm::ivec3> voxels);

/// The reference as a marcher. Its layers are `error` (its own bound), `transmittance`, and `depth`
/// for maxima and surfaces; it counts cells.
class ReferenceMarcher : public Marcher {
 public:
  std::string description() const override {
    return "reference, adaptive quadrature in double precision on the CPU";
  }
  bool marches() const override { return false; }
  void upload(const MediumAtlas&, Filter) override {}
  LightDepths light_depths(const View& view) override { return reference_light_depths(view); }
  RenderResult render(const View& view, const RenderOptions& options) override;
};

}  // namespace psivox
