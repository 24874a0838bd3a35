#include "notices.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "psivox/parameters.h"
#include "psivox/text.h"

namespace psivox {

void print_notices(const View& view, const Scene& scene) {
  // Fields made from one grid repeat its notices.
  std::vector<std::string> printed;
  const Medium& medium = view.medium;
  for (const auto& field : {medium.density, medium.luminance, medium.emission}) {
    if (!field) continue;
    for (const std::string& notice : field->notices) {
      if (std::find(printed.begin(), printed.end(), notice) != printed.end()) continue;
      printed.push_back(notice);
    }
  }
  print_notices(printed);
  if (scene.up_axis == UpAxis::automatic && !scene.camera_up && !view.subject->z_up.empty())
    std::fprintf(stderr, "psivox: Z is up (%s); --up-axis y changes that\n",
                 view.subject->z_up.c_str());
  const auto print_choice = [&](const char* name) {
    const Parameter& p = *find_parameter(name);
    const std::string unit = p.unit.empty() ? "" : " [" + p.unit + "]";
    std::fprintf(stderr, "psivox: %s %s%s, chosen by auto\n", name,
                 parameter_text(view.scene, p).c_str(), unit.c_str());
  };
  if (!scene.extinction && scene.attenuates()) print_choice("extinction");
  if (!scene.isovalue && scene.mode == Mode::isosurface) print_choice("isovalue");
}

void print_look(const LookedScene& looked) {
  if (!looked.dark_because.empty())
    std::fprintf(stderr, "psivox: the picture has no light: %s\n", looked.dark_because.c_str());
  if (!looked.settings.empty()) {
    std::string options;
    for (const Setting& setting : looked.settings)
      options += " --" + setting.name + "=" + setting.text;
    std::fprintf(stderr, "psivox: look %s:%s\n", looked.look.c_str(), options.c_str());
  }
  if (!looked.unused_grids.empty())
    std::fprintf(stderr, "psivox: not shown: %s; --grid and others show them\n",
                 joined(looked.unused_grids, ", ").c_str());
}

void print_notices(std::span<const std::string> notices) {
  for (const std::string& notice : notices) std::fprintf(stderr, "psivox: %s\n", notice.c_str());
}

}  // namespace psivox
