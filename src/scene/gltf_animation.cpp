// Khronos Group, glTF 2.0 Specification, 2021: 3.11 animations, appendix C interpolation.

#include "scene/gltf_camera.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/text_file.h"
#include "psivox/error.h"

namespace psivox {
namespace {

using Json = nlohmann::ordered_json;

[[noreturn]] void refuse(const std::string& source, const char* why) {
  throw Error(ExitCode::input, source + ": " + why);
}

std::string decoded_base64(std::string_view text) {
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    unsigned value = 0;
    if (c >= 'A' && c <= 'Z')
      value = unsigned(c - 'A');
    else if (c >= 'a' && c <= 'z')
      value = unsigned(c - 'a') + 26;
    else if (c >= '0' && c <= '9')
      value = unsigned(c - '0') + 52;
    else if (c == '+')
      value = 62;
    else if (c == '/')
      value = 63;
    else
      break;
    bits = bits << 6 | value;
    if ((count += 6) < 8) continue;
    count -= 8;
    bytes += char(bits >> count & 0xff);
  }
  return bytes;
}

std::vector<std::string> buffers_of(const Json& gltf, const std::string& glb,
                                    const std::string& source) {
  std::vector<std::string> buffers;
  for (const Json& buffer : gltf.value("buffers", Json::array())) {
    const std::string uri = buffer.value("uri", "");
    const std::size_t data = uri.find(";base64,");
    if (uri.empty())
      buffers.push_back(glb);
    else if (uri.starts_with("data:") && data != std::string::npos)
      buffers.push_back(decoded_base64(std::string_view(uri).substr(data + 8)));
    else
      buffers.push_back(
          read_text((std::filesystem::path(source).parent_path() / uri).string(), "buffer"));
  }
  return buffers;
}

/// The floats of an accessor.
std::vector<double> numbers_of(const Json& gltf, const std::vector<std::string>& buffers,
                               std::size_t index, const std::string& source) {
  constexpr int float_type = 5126;
  const Json& accessor = gltf.at("accessors").at(index);
  const Json& view = gltf.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
  if (accessor.at("componentType") != float_type || accessor.contains("sparse"))
    refuse(source, "its animation has other numbers than floats");
  const std::string type = accessor.at("type");
  const std::size_t parts = type == "SCALAR" ? 1 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 0;
  const std::size_t stride = view.value("byteStride", parts * sizeof(float));
  const std::size_t begin =
      view.value("byteOffset", std::size_t{0}) + accessor.value("byteOffset", std::size_t{0});
  const auto buffer = view.at("buffer").get<std::size_t>();
  if (buffer >= buffers.size()) refuse(source, "its animation's buffer is missing");
  const std::string& bytes = buffers[buffer];
  const auto count = accessor.at("count").get<std::size_t>();
  const bool whole = parts > 0 && count > 0 && stride <= bytes.size() && begin <= bytes.size() &&
                     count <= bytes.size() &&
                     begin + (count - 1) * stride + parts * sizeof(float) <= bytes.size();
  if (!whole) refuse(source, "its animation's buffer is too short");
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < parts; ++k) {
      float value = 0;
      std::memcpy(&value, bytes.data() + begin + i * stride + k * sizeof value, sizeof value);
      numbers.push_back(double(value));
    }
  return numbers;
}

/// Values of one property of a node over time.
struct Channel {
  std::size_t node = 0;
  std::string property;       ///< translation, rotation or scale
  std::string interpolation;  ///< LINEAR, STEP or CUBICSPLINE
  std::size_t parts = 3;      ///< of a value
  std::vector<double> times;  ///< [s], ascending
  std::vector<double> values;

  bool cubic() const { return interpolation == "CUBICSPLINE"; }
  /// Value `which` of a key: of a spline 0 and 2 are its tangents and 1 itself.
  std::vector<double> key(std::size_t i, std::size_t which = 1) const {
    const std::size_t begin = (cubic() ? 3 * i + which : i) * parts;
    return {values.begin() + std::ptrdiff_t(begin), values.begin() + std::ptrdiff_t(begin + parts)};
  }
  std::vector<double> at(double seconds) const;
};

glm::dquat quaternion(const std::vector<double>& v) { return {v[3], v[0], v[1], v[2]}; }

std::vector<double> Channel::at(double seconds) const {
  const auto after = std::size_t(std::ranges::upper_bound(times, seconds) - times.begin());
  if (after == 0) return key(0);
  if (after == times.size() || interpolation == "STEP") return key(after - 1);
  const double length = times[after] - times[after - 1];
  const double s = (seconds - times[after - 1]) / length;
  std::vector<double> a = key(after - 1);
  const std::vector<double> b = key(after);
  if (cubic()) {
    const std::vector<double> leave = key(after - 1, 2), arrive = key(after, 0);
    const double s2 = s * s, s3 = s2 * s;
    for (std::size_t k = 0; k < parts; ++k)
      a[k] = (2 * s3 - 3 * s2 + 1) * a[k] + length * (s3 - 2 * s2 + s) * leave[k] +
             (3 * s2 - 2 * s3) * b[k] + length * (s3 - s2) * arrive[k];
  } else if (property == "rotation") {
    const glm::dquat q = glm::slerp(quaternion(a), quaternion(b), s);
    a = {q.x, q.y, q.z, q.w};
  } else {
    for (std::size_t k = 0; k < parts; ++k) a[k] += s * (b[k] - a[k]);
  }
  if (property == "rotation") {
    const glm::dquat q = glm::normalize(quaternion(a));
    a = {q.x, q.y, q.z, q.w};
  }
  return a;
}

std::vector<Channel> channels_of(const Json& gltf, const std::vector<std::string>& buffers,
                                 const std::string& source) {
  std::vector<Channel> channels;
  for (const Json& animation : gltf.value("animations", Json::array()))
    for (const Json& entry : animation.at("channels")) {
      const Json& target = entry.at("target");
      const std::string property = target.at("path");
      const bool moves = property == "translation" || property == "rotation" || property == "scale";
      if (!moves || !target.contains("node")) continue;
      const Json& sampler = animation.at("samplers").at(entry.at("sampler").get<std::size_t>());
      Channel channel{target.at("node"),
                      property,
                      sampler.value("interpolation", "LINEAR"),
                      property == "rotation" ? 4u : 3u,
                      numbers_of(gltf, buffers, sampler.at("input"), source),
                      numbers_of(gltf, buffers, sampler.at("output"), source)};
      const std::size_t needed = channel.times.size() * channel.parts * (channel.cubic() ? 3 : 1);
      if (channel.values.size() < needed || !std::ranges::is_sorted(channel.times))
        refuse(source, "its animation has keys without values or order");
      channels.push_back(std::move(channel));
    }
  return channels;
}

}  // namespace

CameraAnimation animation_from_gltf(const std::string& bytes, const std::string& name,
                                    const std::string& source) {
  const bool binary = source.ends_with(".glb");
  try {
    const auto gltf =
        std::make_shared<const Json>(Json::parse(binary ? json_of_glb(bytes, source) : bytes));
    const auto channels = std::make_shared<const std::vector<Channel>>(channels_of(
        *gltf, buffers_of(*gltf, binary ? buffer_of_glb(bytes, source) : "", source), source));
    if (channels->empty()) refuse(source, "nothing in it is animated; --camera takes a still one");
    CameraAnimation animation{std::numeric_limits<double>::infinity(), 0, {}};
    for (const Channel& channel : *channels) {
      animation.begin = std::min(animation.begin, channel.times.front());
      animation.end = std::max(animation.end, channel.times.back());
    }
    animation.at = [gltf, channels, name, source](double seconds) {
      try {
        Json moved = {{"scene", 0}};
        for (const char* part : {"nodes", "cameras"}) moved[part] = gltf->at(part);
        for (const Channel& channel : *channels)
          moved["nodes"].at(channel.node)[channel.property] = channel.at(seconds);
        return camera_from_gltf(moved, name, source);
      } catch (const Json::exception&) {
        refuse(source, "is not a valid glTF file");
      }
    };
    return animation;
  } catch (const Json::exception&) {
    refuse(source, "is not a valid glTF file");
  }
}

}  // namespace psivox
