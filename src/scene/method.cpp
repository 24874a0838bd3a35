#include "psivox/method.h"

#include <algorithm>
#include <cstdio>

namespace psivox {

std::string method_text(const Method& method) {
  std::string rule = info(method.integrator).name;
  std::replace(rule.begin(), rule.end(), '_', '-');
  char text[96];
  if (method.sampling == Sampling::uniform)
    std::snprintf(text, sizeof text, "uniform %s, step %.3g", rule.c_str(), method.step);
  else if (is_cell_rule(method.integrator))
    std::snprintf(text, sizeof text, "cells %s", rule.c_str());
  else
    std::snprintf(text, sizeof text, "cells %s, segments %d", rule.c_str(), method.segments);
  return text;
}

Scene with_method(Scene scene, const Method& method) {
  scene.tolerance.reset();
  scene.sampling = method.sampling;
  scene.integrator = method.integrator;
  scene.segments = method.segments > 0 ? method.segments : Scene{}.segments;
  scene.step.reset();
  if (method.step > 0) scene.step = method.step;
  return scene;
}

}  // namespace psivox
