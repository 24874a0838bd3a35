#include "notices.h"

#include <cstdio>

#include "base/text.h"
#include "psivox/parameters.h"

namespace psivox {

std::string look_text(const std::string& look, std::span<const Setting> settings, bool to_copy,
                      const std::string& how) {
  std::string text = "look " + look;
  if (!to_copy) return text + "; " + how;
  for (const Setting& setting : settings)
    text += (&setting == &settings.front() ? ": --" : " --") + setting.name + "=" + setting.text;
  return text;
}

void print_look(const LookedScene& looked, bool to_copy, const std::string& how) {
  if (!looked.dark_because.empty())
    std::fprintf(stderr, "psivox: %s: %s\n",
                 looked.scene.lit() ? "the look is plain" : "the picture has no light",
                 looked.dark_because.c_str());
  if (!looked.settings.empty())
    std::fprintf(stderr, "psivox: %s\n",
                 look_text(looked.look, looked.settings, to_copy, how).c_str());
  if (looked.guesses_up)
    std::fprintf(stderr,
                 "psivox: nothing tells which axis is up, so Y is; --up-axis z changes that\n");
  if (!looked.unused_grids.empty())
    std::fprintf(stderr, "psivox: not shown: %s; --grid and others show them\n",
                 joined(looked.unused_grids, ", ").c_str());
}

void print_notices(std::span<const std::string> notices) {
  for (const std::string& notice : notices) std::fprintf(stderr, "psivox: %s\n", notice.c_str());
}

void print_choices(const OpenedScene& opened, bool to_copy) {
  const View& view = opened.view;
  const Scene& scene = opened.looked.scene;
  print_notices(notices_of(view.medium));
  if (scene.up_axis == UpAxis::automatic && !scene.camera_up && !view.subject->z_up.empty())
    std::fprintf(stderr, "psivox: Z is up (%s); --up-axis y changes that\n",
                 view.subject->z_up.c_str());
  const auto print_choice = [&](const char* name, double value) {
    const std::string text = to_copy ? "--" + std::string(name) + "=" + number_text(value)
                                     : std::string(name) + formatted(" %.3g", value);
    std::fprintf(stderr, "psivox: %s, chosen by auto\n", text.c_str());
  };
  if (!scene.extinction && scene.attenuates()) print_choice("extinction", *view.scene.extinction);
  if (!scene.isovalue && scene.shows(Shows::surface))
    print_choice("isovalue", *view.scene.isovalue);
}

}  // namespace psivox
