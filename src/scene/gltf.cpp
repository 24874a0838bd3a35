// Khronos Group, glTF 2.0 Specification, 2021: 3.10 cameras, 3.11 animations, 5.25 nodes, 4.4 GLB,
// appendix C interpolation.

#include "scene/camera_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "scene/json_problem.h"

namespace psivox {
namespace {

using Json = nlohmann::ordered_json;

[[noreturn]] void refuse(const std::string& source, const char* why) {
  throw Error(ExitCode::input, source + ": " + why);
}

constexpr std::size_t glb_header = 12, chunk_header = 8;  // a chunk's: its length and its type

/// A chunk of a .glb file; unset if the file ends before it.
std::optional<std::string> chunk_of_glb(const std::string& bytes, std::size_t at,
                                        const char* type) {
  std::uint32_t length = 0;
  if (bytes.size() < at + chunk_header || bytes.compare(at + 4, 4, type, 4) != 0) return {};
  std::memcpy(&length, bytes.data() + at, sizeof length);
  if (length > bytes.size() - at - chunk_header) return {};
  return bytes.substr(at + chunk_header, length);
}

/// The JSON of a .gltf or .glb file.
Json parsed_gltf(const std::string& bytes, const std::string& source) {
  if (!source.ends_with(".glb")) return shallow_json<Json>(bytes, source, ExitCode::input);
  const std::optional<std::string> text = chunk_of_glb(bytes, glb_header, "JSON");
  if (!bytes.starts_with("glTF") || !text) refuse(source, "is not a valid .glb file");
  return shallow_json<Json>(*text, source, ExitCode::input);
}

/// The binary chunk of a .glb file; empty if there is none.
std::string buffer_of_glb(const std::string& bytes) {
  const std::size_t next =
      glb_header + chunk_header + chunk_of_glb(bytes, glb_header, "JSON").value_or("").size();
  return chunk_of_glb(bytes, next, "BIN\0").value_or("");
}

/// Does what may meet invalid JSON.
template <typename Work>
auto with_json(const std::string& source, const Work& work) {
  try {
    return work();
  } catch (const Json::exception&) {
    refuse(source, "is not a valid glTF file");
  }
}

constexpr const char* distance_name = "target_distance";  // among a node's extras

glm::dmat4 local_transform(const Json& node) {
  if (node.contains("matrix"))
    return glm::make_mat4(node["matrix"].get<std::array<double, 16>>().data());
  const auto place = node.value("translation", std::array{0.0, 0.0, 0.0});
  const auto turn = node.value("rotation", std::array{0.0, 0.0, 0.0, 1.0});
  const auto size = node.value("scale", std::array{1.0, 1.0, 1.0});
  const glm::dmat4 moved = glm::translate(glm::dmat4(1), glm::make_vec3(place.data()));
  return glm::scale(moved * glm::mat4_cast(glm::dquat(turn[3], turn[0], turn[1], turn[2])),
                    glm::make_vec3(size.data()));
}

/// A node that has a camera, and where it is.
struct CameraNode {
  std::string name, camera_name;
  std::size_t camera = 0;
  glm::dmat4 world_from_node{1.0};
  std::optional<double> target_distance;
};

/// Collects the cameras of a root and of the nodes below it, and marks these nodes. A file may have
/// more levels than the stack holds.
void collect(const Json& nodes, const Json& cameras, std::size_t root, std::vector<bool>& seen,
             std::vector<CameraNode>& found) {
  std::vector<std::pair<std::size_t, glm::dmat4>> open{{root, glm::dmat4(1)}};
  while (!open.empty()) {
    const auto [index, parent] = open.back();
    open.pop_back();
    const Json& node = nodes.at(index);
    if (seen[index]) throw Json::other_error::create(500, "a node has two parents", nullptr);
    seen[index] = true;
    const glm::dmat4 world = parent * local_transform(node);
    if (node.contains("camera")) {
      CameraNode row{node.value("name", ""), "", node["camera"].get<std::size_t>(), world, {}};
      row.camera_name = cameras.at(row.camera).value("name", "");
      if (node.contains("extras") && node["extras"].contains(distance_name))
        row.target_distance = node["extras"][distance_name].get<double>();
      found.push_back(row);
    }
    const auto children = node.value("children", std::vector<std::size_t>());
    for (auto child = children.rbegin(); child != children.rend(); ++child)
      open.emplace_back(*child, world);
  }
}

std::vector<CameraNode> camera_nodes(const Json& gltf) {
  std::vector<CameraNode> found;
  const Json nodes = gltf.value("nodes", Json::array());
  const Json cameras = gltf.value("cameras", Json::array());
  std::vector<bool> is_child(nodes.size()), seen(nodes.size());
  for (const Json& node : nodes)
    for (const Json& child : node.value("children", Json::array()))
      if (child.get<std::size_t>() < is_child.size()) is_child[child.get<std::size_t>()] = true;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (!is_child[i]) collect(nodes, cameras, i, seen, found);
  return found;
}

const CameraNode& choose(const std::vector<CameraNode>& found, const std::string& name,
                         const std::string& source) {
  if (found.empty()) throw Error(ExitCode::input, source + ": no node of it has a camera");
  if (name.empty()) return found.front();
  std::vector<std::string> names;
  for (const CameraNode& row : found) {
    if (row.name == name || row.camera_name == name) return row;
    names.push_back(in_quotes(row.name.empty() ? row.camera_name : row.name));
  }
  throw Error(ExitCode::input,
              source + ": has no camera " + in_quotes(name) + "; it has " + joined(names, ", "));
}

/// What the camera looks at: as far away as psivox wrote, else next to the world's origin.
double distance_of(const CameraNode& row, const glm::dvec3& position, const glm::dvec3& forward) {
  if (row.target_distance && *row.target_distance > 0) return *row.target_distance;
  const double nearest = glm::dot(-position, forward);
  return nearest > 0 ? nearest : 1;
}

FileCamera camera_of(const Json& gltf, const std::string& name, const std::string& source) {
  const std::vector<CameraNode> found = camera_nodes(gltf);
  const CameraNode& row = choose(found, name, source);
  const Json& data = gltf.at("cameras").at(row.camera);
  FileCamera camera;
  const glm::dmat3 axes(row.world_from_node);
  const glm::dvec3 forward = -glm::normalize(axes[2]);
  camera.position = glm::dvec3(row.world_from_node[3]);
  camera.up = glm::normalize(axes[1]);
  camera.target = camera.position + distance_of(row, camera.position, forward) * forward;
  if (data.at("type") == "orthographic") {
    camera.projection = Projection::orthographic;
    camera.height = 2 * data.at("orthographic").at("ymag").get<double>();
  } else {
    camera.vertical_fov = glm::degrees(data.at("perspective").at("yfov").get<double>());
  }
  return camera;
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
      buffers.push_back(from_base64(std::string_view(uri).substr(data + 8)));
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
      if (!std::isfinite(value)) refuse(source, "its animation has a number that is not finite");
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
  glm::dvec4 key(std::size_t i, std::size_t which = 1) const {
    glm::dvec4 value(0);
    for (std::size_t k = 0; k < parts; ++k)
      value[int(k)] = values[(cubic() ? 3 * i + which : i) * parts + k];
    return value;
  }
  glm::dvec4 at(double seconds) const;
};

glm::dquat quaternion(const glm::dvec4& v) { return {v.w, v.x, v.y, v.z}; }
glm::dvec4 vector(const glm::dquat& q) { return {q.x, q.y, q.z, q.w}; }

glm::dvec4 Channel::at(double seconds) const {
  const auto after = std::size_t(std::ranges::upper_bound(times, seconds) - times.begin());
  if (after == 0) return key(0);
  if (after == times.size() || interpolation == "STEP") return key(after - 1);
  const double length = times[after] - times[after - 1];
  const double s = (seconds - times[after - 1]) / length;
  const glm::dvec4 a = key(after - 1), b = key(after);
  glm::dvec4 value = a + s * (b - a);
  if (cubic()) {
    const glm::dvec4 leave = key(after - 1, 2), arrive = key(after, 0);
    const double s2 = s * s, s3 = s2 * s;
    value = (2 * s3 - 3 * s2 + 1) * a + length * (s3 - 2 * s2 + s) * leave + (3 * s2 - 2 * s3) * b +
            length * (s3 - s2) * arrive;
  } else if (property == "rotation") {
    value = vector(glm::slerp(quaternion(a), quaternion(b), s));
  }
  return property == "rotation" ? vector(glm::normalize(quaternion(value))) : value;
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

FileCamera camera_from_gltf(const std::string& bytes, const std::string& name,
                            const std::string& source) {
  return with_json(source, [&] { return camera_of(parsed_gltf(bytes, source), name, source); });
}

std::string gltf_of(const FileCamera& camera, double aspect) {
  const double distance = glm::length(camera.target - camera.position);
  const glm::dvec3 forward = (camera.target - camera.position) / distance;
  const glm::dvec3 right = glm::normalize(glm::cross(forward, camera.up));
  const glm::dquat turn = glm::quat_cast(glm::dmat3(right, glm::cross(right, forward), -forward));
  Json data = {{"name", "psivox"}};
  if (camera.projection == Projection::orthographic) {
    data["type"] = "orthographic";
    data["orthographic"] = {{"xmag", camera.height / 2 * aspect},
                            {"ymag", camera.height / 2},
                            {"znear", 0},
                            {"zfar", 100 * distance}};
  } else {
    data["type"] = "perspective";
    data["perspective"] = {{"yfov", glm::radians(camera.vertical_fov)},
                           {"aspectRatio", aspect},
                           {"znear", distance / 1000},
                           {"zfar", 100 * distance}};
  }
  const Json node = {{"name", "psivox"},
                     {"camera", 0},
                     {"translation", {camera.position.x, camera.position.y, camera.position.z}},
                     {"rotation", {turn.x, turn.y, turn.z, turn.w}},
                     {"extras", {{distance_name, distance}}}};
  const Json gltf = {
      {"asset", {{"version", "2.0"}, {"generator", std::string("psivox ") + PSIVOX_VERSION}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"nodes", {node}},
      {"cameras", {data}}};
  return gltf.dump(2) + "\n";
}

CameraAnimation animation_from_gltf(const std::string& bytes, const std::string& name,
                                    const std::string& source) {
  return with_json(source, [&] {
    const auto gltf = std::make_shared<const Json>(parsed_gltf(bytes, source));
    const std::string glb = source.ends_with(".glb") ? buffer_of_glb(bytes) : "";
    const auto channels = std::make_shared<const std::vector<Channel>>(
        channels_of(*gltf, buffers_of(*gltf, glb, source), source));
    if (channels->empty()) refuse(source, "nothing in it is animated; --camera takes a still one");
    CameraAnimation animation{HUGE_VAL, 0, {}};
    for (const Channel& channel : *channels) {
      animation.begin = std::min(animation.begin, channel.times.front());
      animation.end = std::max(animation.end, channel.times.back());
    }
    animation.at = [gltf, channels, name, source](double seconds) {
      return with_json(source, [&] {
        Json moved = {{"scene", 0}};
        for (const char* part : {"nodes", "cameras"}) moved[part] = gltf->at(part);
        for (const Channel& channel : *channels) {
          const glm::dvec4 value = channel.at(seconds);
          Json& numbers = moved["nodes"].at(channel.node)[channel.property] = Json::array();
          for (int k = 0; k < int(channel.parts); ++k) numbers.push_back(value[k]);
        }
        return camera_of(moved, name, source);
      });
    };
    return animation;
  });
}

}  // namespace psivox
