#include "view/widgets.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "psivox/error.h"
#include "psivox/parameters.h"

namespace psivox::view {
namespace {

/// Parameters that the window sets, or that hold from the start on.
constexpr const char* left_out[] = {"input",     "resolution", "device",    "look", "exposure",
                                    "tone-map",  "color-bar",  "scale-bar", "ocio", "ocio-display",
                                    "ocio-view", "ocio-space", "axes",      "box",  "title"};

std::string help_of(const Parameter& p) {
  std::string text = "--" + p.name + ": " + p.help;
  if (!p.unit.empty()) text += " [" + p.unit + "]";
  return text + "\ndefault: " + p.default_text;
}

bool choose(const char* label, std::string& text, const std::vector<std::string>& words) {
  bool changed = false;
  const auto shown = [](const std::string& word) { return word.empty() ? "none" : word; };
  if (!ImGui::BeginCombo(label, shown(text).c_str())) return false;
  for (std::size_t i = 0; i < words.size(); ++i)
    // ImGui aborts on an empty label, and takes two that are alike for one
    if (ImGui::Selectable((shown(words[i]) + "##" + std::to_string(i)).c_str(), words[i] == text)) {
      changed = words[i] != text;
      text = words[i];
    }
  ImGui::EndCombo();
  return changed;
}

std::string digits(double value) { return formatted("%.4g", value); }

/// A number that a drag changes in proportion to itself.
bool drag(const char* label, std::string& text, double value, const Range& range) {
  const double size = std::max(std::abs(value), 1e-3);
  const double low = range.min, high = range.max;
  double now = value;
  // ImGui takes bounds only within half the range of double
  const double least = std::max(low, -1e30), most = std::min(high, 1e30);
  if (!ImGui::DragScalar(label, ImGuiDataType_Double, &now, float(0.01 * size), &least, &most,
                         "%.5g"))
    return false;
  if (range.min_open && now <= low) now = std::max(low + 1e-3 * size, 0.5 * (low + value));
  if (range.max_open && now >= high) now = 0.5 * (high + value);
  text = digits(now);
  return true;
}

bool colour(const char* label, std::string& text, const glm::dvec3& value, const Range& range) {
  float rgb[3] = {float(value.x), float(value.y), float(value.z)};
  if (!ImGui::ColorEdit3(label, rgb, ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR))
    return false;
  // with a decimal point, so that no number is taken as a code
  const auto within = [&](float part) { return std::clamp(double(part), range.min, range.max); };
  text = formatted("%#.4g,%#.4g,%#.4g", within(rgb[0]), within(rgb[1]), within(rgb[2]));
  return true;
}

bool type_text(const char* label, std::string& text) {
  return ImGui::InputText(label, &text, ImGuiInputTextFlags_EnterReturnsTrue);
}

/// A number that is not set: a button sets it to `start`.
bool close_open(const Parameter& p, std::string& text, double start) {
  const std::string button = p.unset + "##" + p.name;
  const bool pressed = ImGui::Button(button.c_str(), {ImGui::CalcItemWidth(), 0});
  ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x);
  ImGui::TextUnformatted(p.name.c_str());
  if (pressed) text = digits(start);
  return pressed;
}

/// The number in effect where none is set, or one to begin with.
double start_of(const Parameter& p, const Scene& resolved) {
  if (p.name == "early-termination") return resolved.resolved_early_termination();
  if (p.name == "fov") return horizontal_fov(resolved);
  if (p.name == "step") return resolved.resolved_step();
  const auto* member = std::get_if<std::optional<double> Scene::*>(&p.member);
  return member && resolved.**member ? *(resolved.**member) : 1;
}

/// The widget for a value of type T; null: not set.
template <typename T>
bool edit_value(const Parameter& p, const T* value, const ParameterChoices& choices,
                std::string& text) {
  const char* label = p.name.c_str();
  if constexpr (std::is_same_v<T, bool>) {
    bool on = *value;
    const bool done = ImGui::Checkbox(label, &on);
    text = on ? "true" : "false";
    return done;
  } else if constexpr (std::is_enum_v<T>) {
    std::vector<std::string> words = split(p.metavar, '|');
    if (!p.unset.empty()) words.insert(words.begin(), p.unset);
    return choose(label, text, words);
  } else if constexpr (std::is_same_v<T, int>) {
    int now = *value;
    const bool done = ImGui::DragInt(label, &now, 0.1f, int(p.range.min), int(p.range.max), "%d",
                                     ImGuiSliderFlags_AlwaysClamp);
    text = std::to_string(now);
    return done;
  } else if constexpr (std::is_same_v<T, double>) {
    return value ? drag(label, text, *value, p.range)
                 : close_open(p, text, start_of(p, choices.resolved));
  } else if constexpr (std::is_same_v<T, glm::dvec3>) {
    if (value && is_color(p)) return colour(label, text, *value, p.range);
    return type_text(label, text);
  } else {
    if (p.metavar != "NAME") return type_text(label, text);
    std::vector<std::string> words(choices.grids.begin(), choices.grids.end());
    words.insert(words.begin(), "");
    return choose(label, text, words);
  }
}

bool edit_text(const Parameter& p, const Scene& scene, const ParameterChoices& choices,
               std::string& text) {
  const auto held = [&](auto member) {
    const auto& value = scene.*member;
    if constexpr (requires { value.has_value(); })
      return edit_value(p, value ? &*value : nullptr, choices, text);
    else
      return edit_value(p, &value, choices, text);
  };
  return std::visit(held, p.member);
}

/// The widget of one parameter, and the button that resets it.
bool edit_parameter(Scene& scene, const Parameter& p, const ParameterChoices& choices) {
  const std::string current = parameter_text(scene, p);
  std::string text = current;
  bool done = edit_text(p, scene, choices, text);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", help_of(p).c_str());
  if (!has_default(scene, p)) {
    ImGui::SameLine();
    if (ImGui::SmallButton(("x##" + p.name).c_str())) {
      text = parameter_text(Scene{}, p);
      done = true;
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("back to the default");
  }
  if (!done || text == current) return false;
  try {
    set_valid(scene, p.name, text);
    return true;
  } catch (const Error& error) {
    choices.refuse(error.what());
    return false;
  }
}

}  // namespace

void set_valid(Scene& scene, const std::string& name, const std::string& text) {
  Scene next = scene;
  const Setting setting{name, text};
  apply_over(next, {&setting, 1});
  validate(next);
  scene = next;
}

bool edit_group(ParameterGroup group, Scene& scene, const ParameterChoices& choices) {
  const bool unfolded = group == ParameterGroup::look || group == ParameterGroup::accuracy;
  if (!ImGui::CollapsingHeader(group_name(group).c_str(),
                               unfolded ? ImGuiTreeNodeFlags_DefaultOpen : 0))
    return false;
  bool changed = false;
  ImGui::PushItemWidth(0.45f * ImGui::GetWindowWidth());
  for (const Parameter& p : parameters())
    if (p.group == group &&
        std::find(std::begin(left_out), std::end(left_out), p.name) == std::end(left_out))
      changed |= edit_parameter(scene, p, choices);
  ImGui::PopItemWidth();
  return changed;
}

bool edit_parameters(Scene& scene, const ParameterChoices& choices,
                     std::span<const char* const> names) {
  bool changed = false;
  ImGui::PushItemWidth(0.45f * ImGui::GetWindowWidth());
  for (const char* name : names)
    if (const Parameter* p = find_parameter(name)) changed |= edit_parameter(scene, *p, choices);
  ImGui::PopItemWidth();
  return changed;
}

}  // namespace psivox::view
