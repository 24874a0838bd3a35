#include "draw/reference_marcher.h"
#include "gl/gl_renderer.h"
#include "march/march_double.h"

namespace psivox {

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
