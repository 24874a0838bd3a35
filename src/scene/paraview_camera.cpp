#include "scene/paraview_camera.h"

#include <map>
#include <pugixml.hpp>
#include <sstream>
#include <vector>

#include "psivox/error.h"
#include "psivox/text.h"

namespace psivox {
namespace {

/// The numbers of ParaView's properties by name.
using Properties = std::map<std::string, std::vector<double>>;

Properties properties_of(const pugi::xml_node& proxy) {
  Properties properties;
  for (const pugi::xml_node& property : proxy.children("Property")) {
    std::vector<double>& values = properties[property.attribute("name").as_string()];
    for (const pugi::xml_node& element : property.children("Element"))
      values.push_back(element.attribute("value").as_double());
  }
  return properties;
}

const std::vector<double>& need(const Properties& properties, const std::string& name,
                                std::size_t count, const std::string& source) {
  const auto found = properties.find(name);
  if (found == properties.end() || found->second.size() < count)
    throw Error(ExitCode::input, source + ": has no " + name + ": not a camera of ParaView's");
  return found->second;
}

glm::dvec3 need_vector(const Properties& properties, const std::string& name,
                       const std::string& source) {
  const std::vector<double>& v = need(properties, name, 3, source);
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
  const Properties properties =
      properties_of(document.child("PVCameraConfiguration").child("Proxy"));
  FileCamera camera;
  camera.position = need_vector(properties, "CameraPosition", source);
  camera.target = need_vector(properties, "CameraFocalPoint", source);
  camera.up = need_vector(properties, "CameraViewUp", source);
  const auto parallel = properties.find("CameraParallelProjection");
  if (parallel != properties.end() && !parallel->second.empty() && parallel->second[0] != 0) {
    camera.projection = Projection::orthographic;
    camera.height = 2 * need(properties, "CameraParallelScale", 1, source)[0];
  } else {
    camera.vertical_fov = need(properties, "CameraViewAngle", 1, source)[0];
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
