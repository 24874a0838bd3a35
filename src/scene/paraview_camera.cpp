// Cameras that ParaView saves (.pvcc).

#include "psivox/error.h"
#include "scene/camera_file.h"
#ifdef PSIVOX_PUGIXML
#include <pugixml.hpp>
#include <sstream>
#include <vector>

#include "base/text.h"

namespace psivox {
namespace {

/// The numbers of one of a proxy's properties, `count` at least.
std::vector<double> numbers_of(const pugi::xml_node& proxy, const std::string& name,
                               std::size_t count, const std::string& source) {
  std::vector<double> values;
  const pugi::xml_node property = proxy.find_child_by_attribute("Property", "name", name.c_str());
  for (const pugi::xml_node& element : property.children("Element"))
    values.push_back(element.attribute("value").as_double());
  if (values.size() < count)
    throw Error(ExitCode::input, source + ": has no " + name + ": not a camera of ParaView's");
  return values;
}

glm::dvec3 vector_of(const pugi::xml_node& proxy, const std::string& name,
                     const std::string& source) {
  const std::vector<double> v = numbers_of(proxy, name, 3, source);
  return {v[0], v[1], v[2]};
}

void append(pugi::xml_node& proxy, const char* name, const std::vector<double>& values) {
  pugi::xml_node property = proxy.append_child("Property");
  property.append_attribute("name") = name;
  property.append_attribute("number_of_elements") = values.size();
  for (std::size_t i = 0; i < values.size(); ++i) {
    pugi::xml_node element = property.append_child("Element");
    element.append_attribute("index") = i;
    element.append_attribute("value") = number_text(values[i]).c_str();
  }
}

std::vector<double> numbers(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

}  // namespace

FileCamera camera_from_paraview(const std::string& text, const std::string& source) {
  pugi::xml_document document;
  if (!document.load_string(text.c_str()))
    throw Error(ExitCode::input, source + ": is not valid XML");
  const pugi::xml_node proxy = document.child("PVCameraConfiguration").child("Proxy");
  FileCamera camera;
  camera.position = vector_of(proxy, "CameraPosition", source);
  camera.target = vector_of(proxy, "CameraFocalPoint", source);
  camera.up = vector_of(proxy, "CameraViewUp", source);
  const std::vector<double> parallel = numbers_of(proxy, "CameraParallelProjection", 0, source);
  if (!parallel.empty() && parallel[0] != 0) {
    camera.projection = Projection::orthographic;
    camera.height = 2 * numbers_of(proxy, "CameraParallelScale", 1, source)[0];
  } else {
    camera.vertical_fov = numbers_of(proxy, "CameraViewAngle", 1, source)[0];
  }
  return camera;
}

std::string paraview_of(const FileCamera& camera) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("PVCameraConfiguration");
  root.append_attribute("description") = "ParaView camera configuration";
  root.append_attribute("version") = "1.0";
  pugi::xml_node proxy = root.append_child("Proxy");
  proxy.append_attribute("group") = "views";
  proxy.append_attribute("type") = "RenderView";
  append(proxy, "CameraPosition", numbers(camera.position));
  append(proxy, "CameraFocalPoint", numbers(camera.target));
  append(proxy, "CameraViewUp", numbers(camera.up));
  append(proxy, "CenterOfRotation", numbers(camera.target));
  append(proxy, "CameraViewAngle", {camera.vertical_fov});
  append(proxy, "CameraParallelScale", {camera.height / 2});
  append(proxy, "CameraParallelProjection",
         {camera.projection == Projection::orthographic ? 1.0 : 0.0});
  std::ostringstream out;
  document.save(out, "  ");
  return out.str();
}

}  // namespace psivox

#else
namespace psivox {

constexpr const char* missing =
    "this psivox reads and writes no .pvcc: it was built without PSIVOX_PUGIXML; take a .gltf";

FileCamera camera_from_paraview(const std::string&, const std::string&) {
  throw Error(ExitCode::usage, missing);
}

std::string paraview_of(const FileCamera&) { throw Error(ExitCode::usage, missing); }

}  // namespace psivox
#endif
