#pragma once

#include "march/marcher.h"

namespace psivox {

/// The reference as a marcher. Its layers are `error` (its own bound), `transmittance`, and `depth`
/// for maxima and surfaces; it counts cells.
class ReferenceMarcher : public Marcher {
 public:
  std::string description() const override;
  bool marches() const override { return false; }
  void upload(const MediumAtlas&, Filter) override {}
  LightDepths light_depths(const View& view) override;
  RenderResult render(const View& view, const RenderOptions& options) override;
};

}  // namespace psivox
