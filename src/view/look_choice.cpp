#include "view/look_choice.h"

#include <regex>

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

/// With four digits of each number, for a person.
std::string shortened(const std::string& options) {
  static const std::regex number(R"(\d+\.\d{3,}(e[+-]?\d+)?)");
  std::string text;
  auto at = options.cbegin();
  for (std::sregex_iterator i(options.cbegin(), options.cend(), number), end; i != end; ++i) {
    text.append(at, (*i)[0].first);
    text += formatted("%.4g", std::stod(i->str()));
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

void LookChoice::take_back(Scene& scene) {
  for (const std::string& name : set_) {
    const Parameter& p = *find_parameter(name);
    if (same(scene, set_scene_, p)) set_default(scene, p);
  }
  set_.clear();
}

void LookChoice::start_again(Scene& scene) {
  take_back(scene);
  ask(start_, scene);
}

void LookChoice::choose(const std::string& name, Scene& scene) {
  take_back(scene);
  scene = without_look(scene);
  ask(name, scene);
}

std::string LookChoice::take(const Volume& volume, Scene& scene) {
  if (!volume.look || !asks_for_look(scene)) return {};
  scene.look = volume.scene.look;
  set_.clear();
  set_scene_ = volume.scene;
  std::string options;
  for (const Setting& setting : volume.look->settings) {
    const Parameter& p = *find_parameter(setting.name);
    options += " --" + setting.name + "=" + setting.text;
    if (!same(scene, volume.asked, p)) continue;
    copy(p, volume.scene, scene);
    set_.push_back(setting.name);
  }
  chosen_ = volume.look->look;
  return "look " + chosen_ + (name_ == "auto" ? ", chosen by auto:" : ":") +
         (options.empty() ? " nothing to set" : shortened(options));
}

std::string LookChoice::text() const {
  if (name_.empty()) return "plain";
  return chosen_.empty() || chosen_ == name_ ? name_ : name_ + ": " + chosen_;
}

}  // namespace psivox::view
