#include "view/look_choice.h"

#include <regex>
#include <utility>

#include "psivox/parameters.h"
#include "psivox/text.h"

namespace psivox::view {
namespace {

bool same(const Scene& a, const Scene& b, const Parameter& p) {
  return parameter_text(a, p) == parameter_text(b, p);
}

void copy(const Parameter& p, const Scene& from, Scene& to) {
  std::visit([&](auto member) { to.*member = from.*member; }, p.member);
}

/// With three digits of each number, for a person.
std::string shortened(const std::string& options) {
  static const std::regex number(R"(\d+\.\d{3,}(e[+-]?\d+)?)");
  std::string text;
  auto at = options.cbegin();
  for (std::sregex_iterator i(options.cbegin(), options.cend(), number), end; i != end; ++i) {
    text.append(at, (*i)[0].first);
    text += formatted("%.3g", std::stod(i->str()));
    at = (*i)[0].second;
  }
  return text.append(at, options.cend());
}

}  // namespace

LookChoice::LookChoice(const Scene& start)
    : start_(leaves_look_open(start) ? "auto" : start.look), name_(start_) {}

void LookChoice::ask(const std::string& name, Scene& scene) {
  name_ = name;
  chosen_.clear();
  scene.look = name;
}

void LookChoice::take_back(Scene& scene, bool camera) {
  for (const std::string& name : std::exchange(set_, {})) {
    const Parameter& p = *find_parameter(name);
    if (!camera && p.group == ParameterGroup::camera) continue;
    if (same(scene, set_scene_, p)) set_default(scene, p);
  }
}

void LookChoice::start_again(Scene& scene) {
  take_back(scene, true);
  ask(start_, scene);
}

void LookChoice::choose(const std::string& name, Scene& scene) {
  take_back(scene, false);
  scene = without_look(scene);
  ask(name, scene);
}

std::string LookChoice::take(const Volume& volume, Scene& scene) {
  if (!volume.chosen) return {};
  const LookedScene& chosen = *volume.chosen;
  const bool asked = asks_for_look(scene);
  if (asked) scene.look = chosen.scene.look;
  set_.clear();
  set_scene_ = chosen.scene;
  std::string options;
  for (const Setting& setting : chosen.settings) {
    const Parameter& p = *find_parameter(setting.name);
    if (p.group != ParameterGroup::camera) options += " --" + setting.name + "=" + setting.text;
    if (!same(scene, volume.asked, p)) continue;
    copy(p, chosen.scene, scene);
    set_.push_back(setting.name);
  }
  if (asked) chosen_ = chosen.look;
  std::string how;
  if (asked && name_ == "auto") how += " by auto";
  if (volume.chosen_from > 1) how += " from " + std::to_string(volume.chosen_from) + " frames";
  std::string text = asked ? "look " + chosen.look : "chosen" + how;
  if (asked && !how.empty()) text += ", chosen" + how;
  return text + ":" + (options.empty() ? " nothing to set" : shortened(options));
}

void LookChoice::hold(const Volume& volume, Scene& scene) {
  for (const Parameter& p : parameters()) {
    const bool part = p.group == ParameterGroup::look || p.group == ParameterGroup::light;
    // grids of a look may be missing in one frame and come again
    if (!part || p.name == "look" || p.name == "emission-grid" || same(scene, volume.resolved, p))
      continue;
    copy(p, volume.resolved, scene);
    copy(p, volume.resolved, set_scene_);
    set_.push_back(p.name);
  }
}

std::string LookChoice::text() const {
  if (name_.empty()) return "plain";
  return chosen_.empty() || chosen_ == name_ ? name_ : name_ + ": " + chosen_;
}

}  // namespace psivox::view
