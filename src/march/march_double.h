#pragma once

#include <glm/vec4.hpp>
#include <memory>
#include <span>

#include "march/marcher.h"

namespace psivox {

/// The march in double precision on the CPU, from the GPU's source: what differs from GlRenderer's
/// picture is arithmetic error, what differs from the reference is step error.
RenderResult render_march_double(const View& view, const MediumAtlas& atlas,
                                 const RenderOptions& options = {});

/// The exact depth towards a beam, through the first volume, from a point of its index space.
/// Several threads may call it. The atlas must outlive it.
using PointDepth = std::function<double(const glm::dvec3& point)>;
PointDepth march_double_light_depth(const View& view, const MediumAtlas& atlas, const Beam& beam);

/// Optical depths towards light through the first volume, over the density's atlas. View and atlas
/// must outlive them.
LightDepths march_double_light_depths(const View& view, const MediumAtlas& atlas);
/// Exact depths from some voxels of the density.
std::vector<double> march_double_light_depths(const View& view, const MediumAtlas& atlas,
                                              const Beam& beam, std::span<const glm::ivec3> voxels);

/// A cell that a ray crosses.
struct Crossed {
  double front = 0, back = 0;  ///< distances from the camera [world units]
  double depth = 0;            ///< optical depth, above 0
};

/// The cells with attenuation that rays cross through a view's first volume, front to back.
/// `places` are in pixels of the picture.
std::vector<std::vector<Crossed>> crossed_cells(const View& view, const MediumAtlas& atlas,
                                                std::span<const glm::dvec2> places);

/// A deep picture, marched in double: in front of every depth, transmittance and radiance are
/// within `tolerance` of the march's. Its first layer is what the samples add up to.
RenderResult render_deep(const View& view, const MediumAtlas& atlas, double tolerance,
                         const Progress& progress = {});

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

class DoubleMarcher : public Marcher {
 public:
  std::string description() const override { return "march in double precision"; }
  bool draws_in_place() const override { return true; }
  void upload(const MediumAtlas& atlas, Filter) override { atlas_ = &atlas; }
  LightDepths light_depths(const View& view) override {
    return march_double_light_depths(view, *atlas_);
  }
  LatticeColumns light_columns(const LatticeFrame& frame, const View& view,
                               const Beam& beam) override;
  RenderResult render(const View& view, const RenderOptions& options) override {
    return render_march_double(view, *atlas_, options);
  }

 private:
  const MediumAtlas* atlas_ = nullptr;
};

struct BrickCodes;
struct MarchSetup;

/// What the ray through a pixel's centre shows.
struct MarchedRay {
  glm::vec4 picture{0};  ///< R G B A
  double samples = 0;    ///< field look-ups
};

/// Marches rays through the centres of single pixels, in double. Atlas and codes must outlive it.
class PixelMarch {
 public:
  /// If there are `codes`, the density's values of float32, and of a luminance beside it, are read
  /// as these would have them: the rays show what the coded atlas would, which nobody stores.
  PixelMarch(const View& view, const MediumAtlas& atlas, const BrickSteps& brick_steps = {},
             const BrickCodes* codes = nullptr);

  /// `progress` is called on this thread, often; it may throw. `ended` gets what `sooner` marches,
  /// the same view but that rays end at a larger transmittance. A ray is marched once.
  void march(std::span<const glm::ivec2> pixels, std::span<MarchedRay> rays,
             const Progress& progress, const PixelMarch* sooner = nullptr,
             std::span<MarchedRay> ended = {}) const;

 private:
  std::shared_ptr<const MarchSetup> setup_;
  const MediumAtlas* atlas_;
  const BrickCodes* codes_;
};

}  // namespace psivox
