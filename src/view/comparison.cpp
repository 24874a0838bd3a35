#include "view/comparison.h"

#include "psivox/parameters.h"

namespace psivox::view {

Scene coarser(const Scene& scene) {
  Scene result = scene;
  result.tolerance.reset();
  if (scene.shows(Shows::surface)) return result;
  result.step = 2 * scene.resolved_step();
  result.sampling = Sampling::uniform;
  result.integrator.reset();
  return result;
}

Scene with_method_of(const Scene& other, Scene scene) {
  for (const Parameter& p : parameters()) {
    const bool differs = p.group == ParameterGroup::accuracy && p.name != "split-knots" &&
                         p.under_tolerance != UnderTolerance::unchanged;
    if (differs) std::visit([&](auto member) { scene.*member = other.*member; }, p.member);
  }
  return scene;
}

}  // namespace psivox::view
