#include "sequence/camera_motion.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "scene/cuts.h"
#include "scene/json_problem.h"

namespace psivox {

Scene turned(Scene scene, double angle) {
  const glm::dvec3 up = glm::normalize(*scene.camera_up);
  const glm::dmat3 turn(glm::rotate(glm::dmat4(1), glm::radians(angle), up));
  scene.camera_position =
      *scene.camera_target + turn * (*scene.camera_position - *scene.camera_target);
  return scene;
}

Scene framed_for_turn(const Scene& scene, const Subject& subject) {
  if (scene.camera_position) return scene;
  constexpr int sides = 24;
  Scene framed = scene;
  if (!framed.camera_target) framed.camera_target = middle_of(subject);
  double distance = 0, half_width = 0;
  for (int i = 0; i < sides; ++i) {
    framed.azimuth = scene.azimuth + 360.0 * i / sides;
    const Camera camera = make_camera(framed, subject);
    distance = std::max(distance, glm::length(camera.position - camera.target));
    half_width = std::max(half_width, camera.half_width);
  }
  framed.azimuth = scene.azimuth;
  const Camera first = make_camera(framed, subject);
  keep_camera(framed, first);
  framed.camera_position = first.target - distance * first.forward;
  if (first.orthographic) framed.ortho_width = 2 * half_width;
  return framed;
}

View followed(View view) {
  Scene own = view.scene;
  own.camera_position.reset();
  own.camera_target.reset();
  const glm::dvec3 target = make_camera(own, *view.subject).target;
  const glm::dvec3 away = view.camera.position - view.camera.target;
  view.scene.camera_target = target;
  view.scene.camera_position = target + away;
  view.camera = make_camera(view.scene, *view.subject);
  return view;
}

namespace {

using nlohmann::json;

[[noreturn]] void refuse(const std::string& why) { throw Error(ExitCode::input, why); }

/// All but `frame` and `ease` are parameters of the camera.
CameraKey key_of(json entry) {
  CameraKey key;
  key.frame = entry.at("frame").get<double>();
  const std::string ease = entry.value("ease", "smooth");
  if (ease != "smooth" && ease != "linear")
    refuse("ease is smooth or linear, not " + in_quotes(ease));
  key.linear = ease == "linear";
  json camera = json::object();
  for (const auto& [name, value] : entry.items())
    if (name != "frame" && name != "ease") camera[(name == "fov" ? "" : "camera-") + name] = value;
  key.camera = scene_from_json(camera.dump(), "a key");
  if (key.camera.camera_up && !has_direction(*key.camera.camera_up))
    refuse("up has no direction: it is 0");
  return key;
}

std::vector<CameraKey> keys_of(const std::string& text) {
  const json file = parsed_json(text, "a camera path", ExitCode::input);
  std::vector<CameraKey> keys;
  try {
    for (const json& entry : file.is_array() ? file : file.at("keys"))
      keys.push_back(key_of(entry));
  } catch (const json::exception&) {
    refuse(
        "expected {\"keys\": [{\"frame\": 1, \"position\": [x,y,z], \"target\": [x,y,z]}, "
        "...]}");
  }
  if (keys.empty()) refuse("it has no key");
  std::ranges::stable_sort(keys, {}, &CameraKey::frame);
  return keys;
}

/// A quantity between two keys that have it, else the one that is there.
template <typename T>
std::optional<T> between(const std::optional<T>& a, const std::optional<T>& b, double s) {
  if (a && b) return *a + s * (*b - *a);
  return a ? a : b;
}

}  // namespace

CameraPath CameraPath::read(const std::string& path, bool z_up, double rate) {
  CameraPath result;
  const std::string who = "camera path " + in_quotes(path) + ": ";
  if (!path.ends_with(".json")) {
    const CameraAnimation animation = read_camera_animation(path, z_up);
    // glTF has seconds in float32
    const auto frame_of = [rate](double seconds) {
      const double number = seconds * rate, whole = std::round(number);
      return std::abs(number - whole) < 1e-3 ? whole : number;
    };
    result.first_ = frame_of(animation.begin);
    result.last_ = frame_of(animation.end);
    result.camera_ = [rate, at = animation.at](double frame) { return at(frame / rate); };
  } else {
    const std::string text = read_text(path, "camera path");
    try {
      result.keys_ = keys_of(text);
    } catch (const Error& error) {
      refuse(who + error.what());
    }
    result.first_ = result.keys_.front().frame;
    result.last_ = result.keys_.back().frame;
  }
  constexpr double most = 1e9;
  if (result.first_ < -most || result.last_ > most) refuse(who + "it has frames beyond a billion");
  return result;
}

Scene CameraPath::at(Scene scene, double frame) const {
  if (camera_) {
    set_camera(scene, camera_(frame));
    return scene;
  }
  auto after = std::ranges::upper_bound(keys_, frame, {}, &CameraKey::frame);
  if (after == keys_.end()) --after;
  const CameraKey& b = *after;
  const CameraKey& a = after == keys_.begin() ? b : *std::prev(after);
  double s = b.frame > a.frame ? std::clamp((frame - a.frame) / (b.frame - a.frame), 0.0, 1.0) : 1;
  if (!a.linear) s = s * s * (3 - 2 * s);
  const auto set = [&](auto member) {
    if (const auto v = between(a.camera.*member, b.camera.*member, s)) scene.*member = v;
  };
  set(&Scene::camera_position);
  set(&Scene::camera_target);
  set(&Scene::camera_up);
  set(&Scene::fov);
  return scene;
}

}  // namespace psivox
