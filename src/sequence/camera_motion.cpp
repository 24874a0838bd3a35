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

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw Error(ExitCode::input, "camera path " + in_quotes(path) + ": " + why);
}

std::optional<glm::dvec3> vector_of(const json& key, const char* name, const std::string& path) {
  if (!key.contains(name)) return {};
  const json& v = key[name];
  if (v.size() != 3) refuse(path, std::string(name) + ": expected [x,y,z], not " + v.dump());
  return glm::dvec3(v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>());
}

CameraKey key_of(const json& entry, const std::string& path) {
  for (const auto& [name, value] : entry.items()) {
    const std::vector<std::string> known{"frame", "position", "target", "up", "fov", "ease"};
    if (std::ranges::find(known, name) == known.end())
      refuse(path, "a key has no " + in_quotes(name) + suggestion(name, known));
  }
  CameraKey key;
  key.frame = entry.at("frame").get<double>();
  key.position = vector_of(entry, "position", path);
  key.target = vector_of(entry, "target", path);
  key.up = vector_of(entry, "up", path);
  if (key.up && !has_direction(*key.up)) refuse(path, "up has no direction: it is 0");
  if (entry.contains("fov")) key.fov = entry["fov"].get<double>();
  if (key.fov && !(*key.fov > 0 && *key.fov < 180))
    refuse(path, "fov is above 0 and below 180 degrees, not " + number_text(*key.fov));
  const std::string ease = entry.value("ease", "smooth");
  if (ease != "smooth" && ease != "linear")
    refuse(path, "ease is smooth or linear, not " + in_quotes(ease));
  key.linear = ease == "linear";
  return key;
}

json parsed(const std::string& text, const std::string& path) {
  try {
    return json::parse(text);
  } catch (const json::exception& error) {
    refuse(path, "not JSON: " + json_problem(text, error));
  }
}

std::vector<CameraKey> keys_of(const std::string& text, const std::string& path) {
  std::vector<CameraKey> keys;
  try {
    const json file = parsed(text, path);
    for (const json& entry : file.is_array() ? file : file.at("keys"))
      keys.push_back(key_of(entry, path));
  } catch (const json::exception&) {
    refuse(path,
           "expected {\"keys\": [{\"frame\": 1, \"position\": [x,y,z], \"target\": [x,y,z]}, "
           "...]}");
  }
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
    result.keys_ = keys_of(read_text(path, "camera path"), path);
    if (result.keys_.empty()) refuse(path, "it has no key");
    std::ranges::stable_sort(result.keys_, {}, &CameraKey::frame);
    result.first_ = result.keys_.front().frame;
    result.last_ = result.keys_.back().frame;
  }
  constexpr double most = 1e9;
  if (result.first_ < -most || result.last_ > most) refuse(path, "it has frames beyond a billion");
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
  if (const auto v = between(a.position, b.position, s)) scene.camera_position = v;
  if (const auto v = between(a.target, b.target, s)) scene.camera_target = v;
  if (const auto v = between(a.up, b.up, s)) scene.camera_up = v;
  if (const auto v = between(a.fov, b.fov, s)) scene.fov = v;
  return scene;
}

}  // namespace psivox
