#include <algorithm>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "psivox/camera_file.h"
#include "psivox/camera_motion.h"
#include "psivox/error.h"
#include "psivox/text.h"
#include "psivox/text_file.h"

namespace psivox {
namespace {

using nlohmann::json;

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw Error(ExitCode::input, "camera path " + in_quotes(path) + ": " + why);
}

std::optional<glm::dvec3> vector_of(const json& key, const char* name) {
  if (!key.contains(name)) return {};
  const json& v = key[name];
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
  key.position = vector_of(entry, "position");
  key.target = vector_of(entry, "target");
  key.up = vector_of(entry, "up");
  if (entry.contains("fov")) key.fov = entry["fov"].get<double>();
  const std::string ease = entry.value("ease", "smooth");
  if (ease != "smooth" && ease != "linear")
    refuse(path, "ease is smooth or linear, not " + in_quotes(ease));
  key.linear = ease == "linear";
  return key;
}

std::vector<CameraKey> keys_of(const std::string& text, const std::string& path) {
  std::vector<CameraKey> keys;
  try {
    const json file = json::parse(text);
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
    result.first_ = animation.begin * rate;
    result.last_ = animation.end * rate;
    result.camera_ = [rate, at = animation.at](double frame) { return at(frame / rate); };
    return result;
  }
  result.keys_ = keys_of(read_text(path, "camera path"), path);
  if (result.keys_.empty()) refuse(path, "it has no key");
  std::ranges::stable_sort(result.keys_, {}, &CameraKey::frame);
  result.first_ = result.keys_.front().frame;
  result.last_ = result.keys_.back().frame;
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
