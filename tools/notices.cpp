#include "notices.h"

#include <unistd.h>

#include <cstdio>
#include <utility>

#include "field/value_range.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

constexpr int bar_width = 40;

/// The surface that a CT has besides one at this value, as the rest of a sentence; empty for what
/// is no CT in Hounsfield units, from air to bone. Skin is between air (-1000) and fat (-100), bone
/// above soft tissue (60) and blood with a contrast agent (250).
std::string other_surface(const Field& density, double isovalue) {
  constexpr double air = -800, dense = 500;
  const glm::dvec2 range = active_range(density);
  if (!density.scale.is_linear() || range.x > air || range.x < 4 * air || range.y < dense ||
      range.y > 10 * dense)
    return "";
  return isovalue < 0 ? "; --isovalue 300 shows bone" : "; --isovalue -300 shows skin";
}

}  // namespace

std::string look_text(const std::string& look, std::span<const Setting> settings, bool to_copy,
                      const std::string& how) {
  std::string text = "look " + look;
  if (!to_copy) return text + "; " + how;
  for (const Setting& setting : settings)
    text += (&setting == &settings.front() ? ": " : " ") +
            shell_word("--" + setting.name + "=" + setting.text);
  return text;
}

void print_dark(const Scene& scene, const std::string& dark_because) {
  if (!dark_because.empty())
    print_notice((scene.lit() ? "the look is plain: " : "the picture has no light: ") +
                 dark_because);
}

void print_look(const LookedScene& looked, bool to_copy, const std::string& how) {
  print_dark(looked.scene, looked.dark_because);
  if (!looked.settings.empty()) print_notice(look_text(looked.look, looked.settings, to_copy, how));
  if (looked.guesses_up)
    print_notice("nothing tells which axis is up, so Y is; --up-axis z changes that");
  if (looked.outside)
    print_notice(
        formatted("%.4g fills the volume around the object, and is transparent; "
                  "--opacity 0:0,1:1 shows it",
                  *looked.outside));
  constexpr std::size_t most_names = 9;
  const std::span<const std::string> unused = looked.unused_grids;
  const std::size_t named = unused.size() > most_names ? most_names - 1 : unused.size();
  if (named > 0)
    print_notice("not shown: " + joined(unused.first(named), ", ") +
                 (named < unused.size() ? formatted(" and %d others, which psivox info lists",
                                                    int(unused.size() - named))
                                        : "") +
                 (looked.scene.given.contains("grid") ? "" : "; --grid NAME draws one of them"));
}

void print_notices(std::span<const std::string> notices) {
  for (const std::string& notice : notices) print_notice(notice);
}

void print_choices(const OpenedScene& opened, bool to_copy) {
  const View& view = opened.view;
  const Scene& scene = opened.looked.scene;
  print_notices(notices_of(view));
  if (scene.up_axis == UpAxis::automatic && !scene.camera_up && !view.subject->z_up.empty())
    print_notice("Z is up (" + view.subject->z_up + "); --up-axis y changes that");
  const auto print_choice = [&](const char* name, double value, const std::string& others = "") {
    print_notice((to_copy ? "--" + std::string(name) + "=" + number_text(value)
                          : name + formatted(" %.3g", value)) +
                 ", chosen by auto" + others);
  };
  if (!scene.extinction && scene.attenuates()) print_choice("extinction", *view.scene.extinction);
  if (scene.isovalue.empty() && scene.shows(Shows::surface)) {
    const double value = view.scene.isovalue.front().value;
    print_choice("isovalue", value, other_surface(*view.medium.density, value));
  }
}

ProgressBar::ProgressBar(bool quiet)
    : quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      marks_(terminal_ ? ProgressMarks(100, 0.3, 0.5) : ProgressMarks(10, 2, 10)) {}

ProgressBar::~ProgressBar() { clear(); }

void ProgressBar::clear() {
  if (std::exchange(drawn_, false)) std::fputs("\r\033[K", stderr);
}

void ProgressBar::say(const std::string& notice) {
  clear();
  print_notice(notice);
}

Progress ProgressBar::progress() {
  if (quiet_) return {};
  start_ = stage_start_ = std::chrono::steady_clock::now();
  left_ = {};
  return [this](double fraction) { show(nullptr, fraction); };
}

StageProgress ProgressBar::stages() {
  if (quiet_) return {};
  start_ = std::chrono::steady_clock::now();
  stage_ = nullptr;
  return [this](Stage stage, double fraction) { show(stage_text(stage), fraction); };
}

void ProgressBar::show(const char* what, double fraction) {
  fraction = std::clamp(fraction, 0.0, 1.0);
  const auto now = std::chrono::steady_clock::now();
  if (what != stage_) {
    stage_ = what;
    stage_start_ = now;
    left_ = {};
    marks_.next_stage();
  }
  const std::chrono::duration<double> passed = now - start_, in_stage = now - stage_start_;
  const std::string left = left_.text(fraction, in_stage.count());
  if (!marks_.passes(fraction, passed.count())) return;
  const int percent = int(fraction * 100);
  const std::string text =
      (what ? std::string(what) + " " : "") + formatted("%d %%", percent) + left;
  if (!terminal_) return print_notice(text);
  drawn_ = true;
  const int filled = int(fraction * bar_width);
  const std::string bar =
      std::string(std::size_t(filled), '#') + std::string(std::size_t(bar_width - filled), '.');
  std::fprintf(stderr, "\r[%s] %s\033[K", bar.c_str(), text.c_str());
  std::fflush(stderr);
}

void FrameNotices::add(const std::string& notice, FrameNumber frame) {
  if (notice.empty()) return;
  std::string key = notice;
  std::erase_if(key, [](char c) { return (c >= '0' && c <= '9') || c == '.'; });
  if (const auto known = all_.find(key);
      known != all_.end() && known->second.frames.back() == frame)
    key = notice;  // two of one frame
  Collected& all = all_[key];
  if (all.frames.empty())
    all.text = notice;
  else if (all.frames.back() == frame)
    return;
  all.differs |= all.text != notice;
  all.frames.push_back(frame);
}

void FrameNotices::say(ProgressBar& bar) {
  for (const auto& [key, all] : std::exchange(all_, {})) {
    const std::string first = std::to_string(all.frames.front());
    bar.say(all.frames.size() == 1
                ? "frame " + first + ": " + all.text
                : "frames " + frames_text(all.frames) + ": " +
                      (all.differs ? "such as, in " + first + ", " : "") + all.text);
  }
}

}  // namespace psivox
