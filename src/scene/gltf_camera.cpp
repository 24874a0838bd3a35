// Khronos Group, glTF 2.0 Specification, 2021: 3.10 cameras, 5.25 nodes, 4.4 GLB.

#include "scene/gltf_camera.h"

#include <cstring>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "base/text.h"
#include "psivox/error.h"
#include "scene/vector_json.h"

namespace psivox {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* distance_name = "target_distance";  // among a node's extras

glm::dvec3 vector(const Json& node, const char* name, const glm::dvec3& absent) {
  if (!node.contains(name)) return absent;
  const Json& v = node.at(name);
  return {v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>()};
}

glm::dmat4 local_transform(const Json& node) {
  if (node.contains("matrix")) {
    glm::dmat4 m;
    for (int i = 0; i < 16; ++i)
      m[i / 4][i % 4] = node["matrix"].at(static_cast<std::size_t>(i)).get<double>();
    return m;
  }
  glm::dmat4 m = glm::translate(glm::dmat4(1), vector(node, "translation", glm::dvec3(0)));
  if (node.contains("rotation")) {
    const Json& q = node["rotation"];
    m *= glm::mat4_cast(glm::dquat(q.at(3).get<double>(), q.at(0).get<double>(),
                                   q.at(1).get<double>(), q.at(2).get<double>()));
  }
  return glm::scale(m, vector(node, "scale", glm::dvec3(1)));
}

/// A node that has a camera, and where it is.
struct CameraNode {
  std::string name, camera_name;
  std::size_t camera = 0;
  glm::dmat4 world_from_node{1.0};
  std::optional<double> target_distance;
};

/// Collects a node's cameras and those below it. A tree is no deeper than it has nodes.
void collect(const Json& nodes, const Json& cameras, std::size_t index, const glm::dmat4& parent,
             std::size_t depth, std::vector<CameraNode>& found) {
  if (depth > nodes.size()) throw Json::other_error::create(500, "nodes form a circle", nullptr);
  const Json& node = nodes.at(index);
  const glm::dmat4 world = parent * local_transform(node);
  if (node.contains("camera")) {
    CameraNode row{node.value("name", ""), "", node["camera"].get<std::size_t>(), world, {}};
    row.camera_name = cameras.at(row.camera).value("name", "");
    if (node.contains("extras") && node["extras"].contains(distance_name))
      row.target_distance = node["extras"][distance_name].get<double>();
    found.push_back(row);
  }
  for (const Json& child : node.value("children", Json::array()))
    collect(nodes, cameras, child.get<std::size_t>(), world, depth + 1, found);
}

std::vector<CameraNode> camera_nodes(const Json& gltf) {
  std::vector<CameraNode> found;
  const Json nodes = gltf.value("nodes", Json::array());
  const Json cameras = gltf.value("cameras", Json::array());
  std::vector<bool> is_child(nodes.size());
  for (const Json& node : nodes)
    for (const Json& child : node.value("children", Json::array()))
      if (child.get<std::size_t>() < is_child.size()) is_child[child.get<std::size_t>()] = true;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (!is_child[i]) collect(nodes, cameras, i, glm::dmat4(1), 0, found);
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

FileCamera camera_of(const Json& gltf, const CameraNode& row) {
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

}  // namespace

FileCamera camera_from_gltf(const Json& gltf, const std::string& name, const std::string& source) {
  const std::vector<CameraNode> found = camera_nodes(gltf);
  return camera_of(gltf, choose(found, name, source));
}

FileCamera camera_from_gltf(const std::string& text, const std::string& name,
                            const std::string& source) {
  try {
    return camera_from_gltf(Json::parse(text), name, source);
  } catch (const Json::exception&) {
    throw Error(ExitCode::input, source + ": is not a valid glTF file");
  }
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
                     {"translation", vector_json(camera.position)},
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

namespace {

/// A chunk of a .glb file; unset if the file ends before it.
std::optional<std::string> chunk_of_glb(const std::string& bytes, std::size_t at,
                                        const char* type) {
  constexpr std::size_t header = 8;  // its length and its type
  std::uint32_t length = 0;
  if (bytes.size() < at + header || bytes.compare(at + 4, 4, type, 4) != 0) return {};
  std::memcpy(&length, bytes.data() + at, sizeof length);
  if (length > bytes.size() - at - header) return {};
  return bytes.substr(at + header, length);
}

constexpr std::size_t glb_header = 12, chunk_header = 8;

}  // namespace

std::string json_of_glb(const std::string& bytes, const std::string& source) {
  const std::optional<std::string> text = chunk_of_glb(bytes, glb_header, "JSON");
  if (!bytes.starts_with("glTF") || !text)
    throw Error(ExitCode::input, source + ": is not a valid .glb file");
  return *text;
}

std::string buffer_of_glb(const std::string& bytes, const std::string& source) {
  const std::size_t next = glb_header + chunk_header + json_of_glb(bytes, source).size();
  return chunk_of_glb(bytes, next, "BIN\0").value_or("");
}

}  // namespace psivox
