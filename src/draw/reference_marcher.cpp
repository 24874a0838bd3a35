#include "draw/reference_marcher.h"

#include "reference/reference.h"

namespace psivox {
namespace {

Layer transmittance_of(const Image& image) {
  Layer layer{"transmittance", {"transmittance"}, {}};
  const auto rgba = image.rgba();
  layer.values.reserve(rgba.size() / 4);
  for (std::size_t i = 3; i < rgba.size(); i += 4) layer.values.push_back(1 - rgba[i]);
  return layer;
}

}  // namespace

std::string ReferenceMarcher::description() const {
  return "reference, adaptive quadrature in double precision on the CPU";
}

LightDepths ReferenceMarcher::light_depths(const View& view) {
  return reference_light_depths(view);
}

RenderResult ReferenceMarcher::render(const View& view, const RenderOptions& options) {
  ReferenceResult drawn = render_reference(view, 1e-12, options.progress);
  RenderResult result;
  RenderStats& stats = result.stats;
  const glm::ivec2 size = view.scene.resolution;
  stats.renderer = description();
  stats.rays =
      std::uint64_t(size.x) * std::uint64_t(size.y) * std::uint64_t(view.scene.pixel_samples);
  stats.cells = drawn.cells;
  stats.march_ms = 1e3 * drawn.seconds;
  if (options.transmittance) drawn.image.layers.push_back(transmittance_of(drawn.image));
  result.image = std::move(drawn.image);
  return result;
}

}  // namespace psivox
