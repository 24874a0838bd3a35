#include "gl/gl_renderer.h"
#include "march/march_double.h"
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

/// The reference as a marcher. Its layers are `error` (its own bound), `transmittance`, and `depth`
/// for maxima and surfaces; it counts cells.
class ReferenceMarcher final : public Marcher {
 public:
  std::string description() const override {
    return "reference, adaptive quadrature in double precision on the CPU";
  }
  bool marches() const override { return false; }
  void upload(const MediumAtlas&, Filter) override {}
  LightDepths light_depths(const View& view) override { return reference_light_depths(view); }
  RenderResult render(const View& view, const RenderOptions& options) override;
};

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

}  // namespace

std::shared_ptr<Marcher> open_gpu(const ContextOptions& options) {
  return std::make_shared<GlRenderer>(options);
}

std::shared_ptr<Marcher> open_double() { return std::make_shared<DoubleMarcher>(); }

std::shared_ptr<Marcher> open_reference() { return std::make_shared<ReferenceMarcher>(); }

std::shared_ptr<Marcher> open_marcher(const Scene& scene) {
  switch (scene.renderer) {
    case RendererKind::reference:
      return open_reference();
    case RendererKind::march_double:
      return open_double();
    case RendererKind::gl:
      break;
  }
  return open_gpu({.device = scene.device});
}

void release(Marcher& marcher) { marcher.release(); }

std::string description(const Marcher& marcher) { return marcher.description(); }

}  // namespace psivox
