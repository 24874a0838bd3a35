#pragma once

#include "march/marcher.h"

namespace psivox {

/// The march in double precision on the CPU, from the GPU's source: what differs from GlRenderer's
/// picture is arithmetic error, what differs from the reference is step error.
RenderResult render_march_double(const View& view, const MediumAtlas& atlas,
                                 const RenderOptions& options = {});

/// Optical depths towards light over the density's atlas. View and atlas must outlive them.
LightDepths march_double_light_depths(const View& view, const MediumAtlas& atlas);
/// Exact depths from some voxels of the density.
std::vector<double> march_double_light_depths(const View& view, const MediumAtlas& atlas,
                                              const Beam& beam, std::span<const glm::ivec3> voxels);

class DoubleMarcher : public Marcher {
 public:
  std::string description() const override { return "march in double precision"; }
  void upload(const MediumAtlas& atlas, Filter) override { atlas_ = &atlas; }
  LightDepths light_depths(const View& view) override {
    return march_double_light_depths(view, *atlas_);
  }
  void with_lattice(const View& view, const Beam& beam, const UseLattice& use) override;
  RenderResult render(const View& view, const RenderOptions& options) override {
    return render_march_double(view, *atlas_, options);
  }

 private:
  const MediumAtlas* atlas_ = nullptr;
};

}  // namespace psivox
