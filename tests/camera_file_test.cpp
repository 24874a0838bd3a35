// Cameras of glTF and of ParaView: the axes, the field of view, nested nodes, bad files.

#include "scene/camera_file.h"
#include "expect_near.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <sstream>
#include <vector>

#include "base/text_file.h"
#include "made_fields.h"
#include "scratch.h"
#include "thrown.h"

namespace psivox {
namespace {

std::string written(const std::string& name, const std::string& text) {
  return test::write_bytes(name, text).string();
}

std::string refusal(const std::string& path) {
  return input_error([&] { read_camera(path, false); });
}

/// A rig that is moved, turned by 90 degrees about Y, and scaled; below it a camera and another.
constexpr const char* rig = R"({
  "nodes": [
    {"name": "lens", "camera": 0, "translation": [0, 0, 5]},
    {"name": "rig", "children": [0, 2], "translation": [1, 2, 3],
     "rotation": [0, 0.70710678118654752, 0, 0.70710678118654752], "scale": [2, 2, 2]},
    {"camera": 1, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,7,0,1]}],
  "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}},
              {"name": "flat", "type": "orthographic",
               "orthographic": {"xmag": 4, "ymag": 3, "znear": 0, "zfar": 9}}]})";

TEST(GltfCamera, IsWhereItsNodesPutIt) {
  const std::string path = written("rig.gltf", rig);
  for (const char* name : {"", ":lens"}) {
    const FileCamera camera = read_camera(path + name, false);
    // 5 along Z, scaled and turned: 10 along X
    expect_near(camera.position, {11, 2, 3}, 1e-12);
    expect_near(glm::normalize(camera.target - camera.position), {-1, 0, 0}, 1e-12);
    expect_near(camera.up, {0, 1, 0}, 1e-12);
    EXPECT_NEAR(camera.vertical_fov, 180 / std::acos(-1.0), 1e-12);
  }
  const FileCamera flat = read_camera(path + ":flat", false);
  EXPECT_EQ(flat.projection, Projection::orthographic);
  EXPECT_EQ(flat.height, 6);
  expect_near(flat.position, {1, 16, 3}, 1e-12);
}

TEST(GltfCamera, IsTurnedForAVolumeWithZUp) {
  // Blender's camera at (1, -10, 2), looking along +Y: glTF has it at (1, 2, 10), along -Z.
  const std::string path = written("front.gltf", R"({
    "nodes": [{"camera": 0, "translation": [1, 2, 10]}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]})");
  const FileCamera camera = read_camera(path, true);
  expect_near(camera.position, {1, -10, 2}, 1e-12);
  expect_near(glm::normalize(camera.target - camera.position), {0, 1, 0}, 1e-12);
  expect_near(camera.up, {0, 0, 1}, 1e-12);
}

TEST(GltfCamera, OfABinaryFileIsRead) {
  const std::string text = rig;
  std::string bytes = "glTF";
  const auto append = [&](std::uint32_t number) {
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>(number >> (8 * i));
  };
  append(2);
  append(static_cast<std::uint32_t>(20 + text.size()));
  append(static_cast<std::uint32_t>(text.size()));
  bytes += "JSON" + text;
  expect_near(read_camera(written("rig.glb", bytes), false).position, {11, 2, 3}, 1e-12);
  EXPECT_NE(refusal(written("cut.glb", bytes.substr(0, 60))), "no error");
  EXPECT_NE(refusal(written("short.glb", "glTF")), "no error");
}

TEST(GltfCamera, BadFilesAreRefusedInOneLine) {
  const auto lines = {
      std::pair("{", "not a valid glTF"),
      {"[]", "not a valid glTF"},
      {R"({"nodes": [{"camera": 0}]})", "not a valid glTF"},
      {R"({"nodes": [{"camera": 0}], "cameras": [{"type": "perspective"}]})", "not a valid glTF"},
      {R"({"nodes": [{"camera": 0}], "cameras":
          [{"type": "perspective", "perspective": {"yfov": 0}}]})",
       "no field of view"},
      {R"({"nodes": [{"name": "a"}]})", "no node of it has a camera"},
      {R"({"nodes": [{"children": [1]}, {"children": [2]}, {"children": [1]}]})",
       "not a valid glTF"},
      {R"({"nodes": [{"children": [1, 1]}, {}]})", "not a valid glTF"},
      {R"({"nodes": [{"camera": 0, "scale": [0, 0, 0]}], "cameras":
          [{"type": "perspective", "perspective": {"yfov": 1}}]})",
       "no direction"}};
  for (const auto& [text, part] : lines) EXPECT_TRUE(has(refusal(written("bad.gltf", text)), part));
  std::string chain = R"({"nodes": [{})";  // deeper than the stack of recursive calls
  for (int i = 0; i < 100000; ++i) chain += ",{\"children\":[" + std::to_string(i) + "]}";
  EXPECT_TRUE(has(refusal(written("bad.gltf", chain + "]}")), "no node"));
  EXPECT_TRUE(has(refusal(written("rig.gltf", rig) + ":none"), "it has 'lens', 'flat'"));
}

constexpr const char* paraview = R"(<?xml version="1.0"?>
<PVCameraConfiguration description="ParaView camera configuration" version="1.0">
  <Proxy group="views" type="RenderView" id="7116" servers="21">
    <Property name="CameraPosition" id="7116.CameraPosition" number_of_elements="3">
      <Element index="0" value="1"/><Element index="1" value="2.5"/><Element index="2" value="30"/>
    </Property>
    <Property name="CameraFocalPoint" id="7116.CameraFocalPoint" number_of_elements="3">
      <Element index="0" value="1"/><Element index="1" value="2.5"/><Element index="2" value="-3"/>
    </Property>
    <Property name="CameraViewUp" id="7116.CameraViewUp" number_of_elements="3">
      <Element index="0" value="0"/><Element index="1" value="1"/><Element index="2" value="0"/>
    </Property>
    <Property name="CameraViewAngle" id="7116.CameraViewAngle" number_of_elements="1">
      <Element index="0" value="30"/>
    </Property>
    <Property name="CameraParallelScale" id="7116.CameraParallelScale" number_of_elements="1">
      <Element index="0" value="8.5"/>
    </Property>
    <Property name="CameraParallelProjection" number_of_elements="1">
      <Element index="0" value="0"/>
    </Property>
  </Proxy>
</PVCameraConfiguration>)";

TEST(ParaViewCamera, IsRead) {
  std::string text = paraview;
  const FileCamera camera = read_camera(written("view.pvcc", text), true);
  EXPECT_EQ(camera.position, glm::dvec3(1, 2.5, 30));
  EXPECT_EQ(camera.target, glm::dvec3(1, 2.5, -3));
  EXPECT_EQ(camera.up, glm::dvec3(0, 1, 0));
  EXPECT_EQ(camera.vertical_fov, 30);
  const std::string perspective = "<Element index=\"0\" value=\"0\"/>\n    </Property>\n  </Proxy>";
  ASSERT_TRUE(has(text, perspective));
  text.replace(text.find(perspective), 31, "<Element index=\"0\" value=\"1\"/>   ");
  const FileCamera flat = read_camera(written("flat.pvcc", text), true);
  EXPECT_EQ(flat.projection, Projection::orthographic);
  EXPECT_EQ(flat.height, 17);
  EXPECT_TRUE(has(refusal(written("bad.pvcc", "<a>")), "not valid XML"));
  EXPECT_TRUE(has(refusal(written("empty.pvcc", "<a/>")), "has no CameraPosition"));
}

const auto recorded = std::filesystem::path(PSIVOX_ASSETS) / "../tests/recorded";

/// What another program sees through a camera of its own.
struct Seen {
  std::string camera;
  int frame = 1;
  std::vector<glm::dvec2> pixels;  ///< of each point, from the top left
};

struct Recorded {
  explicit Recorded(const std::string& name) {
    std::istringstream lines(read_text((recorded / name).string(), "recorded"));
    lines.ignore(6);  // "points"
    std::string line;
    std::getline(lines, line);
    std::istringstream numbers(line);
    for (glm::dvec3 p; numbers >> p.x >> p.y >> p.z;) points.push_back(p);
    while (std::getline(lines, line)) {
      std::istringstream words(line);
      Seen& row = seen.emplace_back();
      words >> row.camera >> row.frame;
      for (glm::dvec2 p; words >> p.x >> p.y;) row.pixels.push_back(p);
    }
  }

  /// The largest distance of a point from the ray of its pixel [pixels].
  double largest_distance(const Seen& row, const FileCamera& read) const {
    EXPECT_EQ(row.pixels.size(), points.size());
    Scene scene;
    scene.resolution = {640, 360};
    set_camera(scene, read);
    const Camera camera = make_camera(scene, glm::dvec3(-1), glm::dvec3(1));
    double largest = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const WorldRay ray = camera_ray(camera, scene.resolution, row.pixels[i].x, row.pixels[i].y);
      const glm::dvec3 way = points[i] - ray.origin;
      const double depth = camera.orthographic ? 1 : glm::dot(way, camera.forward);
      const double pixel = depth * 2 * camera.half_width / scene.resolution.x;
      largest = std::max(largest, glm::length(glm::cross(way, ray.direction)) / pixel);
    }
    return largest;
  }

  std::vector<glm::dvec3> points;
  std::vector<Seen> seen;
};

TEST(RecordedCamera, SeesWhatBlenderSees) {
  // Blender computes in float32: 2^-24 of some 100 units are 1e-4 pixels; it printed 1e-3
  constexpr double bound = 2e-3;
  const Recorded blender("blender-3.4.txt");
  const std::string file = (recorded / "blender-3.4.gltf").string();
  const CameraAnimation moving = read_camera_animation(file + ":Moving", true);
  ASSERT_EQ(blender.seen.size(), 7u);
  for (const Seen& row : blender.seen) {
    const FileCamera camera = row.camera == "Moving" ? moving.at(row.frame / 24.0)
                                                     : read_camera(file + ":" + row.camera, true);
    EXPECT_LT(blender.largest_distance(row, camera), bound) << row.camera << " " << row.frame;
  }
  const FileCamera of_other_axes = read_camera(file + ":Camera", false);
  EXPECT_GT(blender.largest_distance(blender.seen[0], of_other_axes), 10);
}

TEST(RecordedCamera, SeesWhatParaViewSees) {
  constexpr double bound = 1e-3;  // it printed 1e-3, rounded, for x and for y
  const Recorded other("paraview-5.11-cameras.txt");
  ASSERT_EQ(other.seen.size(), 2u);
  for (const Seen& row : other.seen) {
    const auto file = recorded / ("paraview-5.11-" + row.camera + ".pvcc");
    EXPECT_LT(other.largest_distance(row, read_camera(file.string(), true)), bound) << file;
  }
}

TEST(CameraFile, KeepsTheVerticalFieldOfView) {
  FileCamera camera;
  camera.vertical_fov = 40;
  for (const glm::ivec2 resolution : {glm::ivec2(300, 200), glm::ivec2(100, 400)}) {
    Scene scene;
    scene.resolution = resolution;
    set_camera(scene, camera);
    const Camera made = make_camera(scene, glm::dvec3(-1), glm::dvec3(1));
    EXPECT_NEAR(made.half_height, std::tan(20 * std::acos(-1.0) / 180), 1e-14);
  }
}

TEST(CameraFile, WhatIsWrittenIsReadAgain) {
  const auto field = share(make_field({{0, 0, 0}, {20, 20, 20}}, [](glm::ivec3) { return 1.0f; }));
  for (const Projection projection : {Projection::perspective, Projection::orthographic})
    for (const UpAxis up : {UpAxis::y, UpAxis::z})
      for (const char* name : {"again.gltf", "again.pvcc"}) {
        Scene scene = small_scene(32);
        scene.projection = projection;
        scene.up_axis = up;
        scene.azimuth = 40;
        scene.elevation = -25;
        const View view = view_of(scene, field);
        const std::string path = (test::scratch_dir() / name).string();
        write_camera(path, view.camera, up == UpAxis::z);
        Scene again = small_scene(32);
        set_camera(again, read_camera(path, up == UpAxis::z));
        const Camera camera = make_camera(again, *view.subject);
        // Some roundings of numbers of the size of the distance, about 100.
        expect_near(camera.position, view.camera.position, 1e-12);
        expect_near(camera.target, view.camera.target, 1e-12);
        expect_near(camera.right, view.camera.right, 1e-14);
        expect_near(camera.up, view.camera.up, 1e-14);
        EXPECT_NEAR(camera.half_width, view.camera.half_width, 1e-14 * view.camera.half_width);
        EXPECT_EQ(camera.orthographic, view.camera.orthographic);
      }
}

}  // namespace
}  // namespace psivox
