#include "psivox/sequence.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "scratch.h"
#include "sequence/camera_motion.h"
#include "thrown.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// A folder with copies of an asset.
class Folder {
 public:
  std::string file(const std::string& name, const std::string& asset = "single_voxel") {
    const fs::path path = path_ / name;
    fs::copy_file(fs::path(PSIVOX_ASSETS) / (asset + ".vdb"), path);
    return path.string();
  }
  std::string path(const std::string& name = "") const {
    return name.empty() ? path_.string() : (path_ / name).string();
  }

 private:
  fs::path path_ = test::empty_scratch_dir();
};

std::vector<FrameNumber> frames_of(const SequenceFiles& files) {
  std::vector<FrameNumber> frames;
  for (const auto& [frame, path] : files) frames.push_back(frame);
  return frames;
}

TEST(FramePattern, PadsAsItsPlaceholderSays) {
  const auto path = [](const std::string& text, FrameNumber frame) {
    return FramePattern::of_placeholder(text)->path(frame);
  };
  EXPECT_EQ(path("a/fire.####.vdb", 7), "a/fire.0007.vdb");
  EXPECT_EQ(path("fire.####.vdb", 12345), "fire.12345.vdb");
  EXPECT_EQ(path("fire.%04d.vdb", 7), "fire.0007.vdb");
  EXPECT_EQ(path("fire.$F4.vdb", 7), "fire.0007.vdb");
  for (const char* text : {"fire#.vdb", "fire%d.vdb", "fire$F.vdb"})
    EXPECT_EQ(path(text, 12), "fire12.vdb") << text;
  EXPECT_FALSE(FramePattern::of_placeholder("fire.0001.vdb"));
  EXPECT_TRUE(
      has(usage_error([&] { FramePattern::of_placeholder("fire.##.##.vdb"); }), "two places"));
  EXPECT_TRUE(has(usage_error([&] { FramePattern::of_placeholder("shot##/fire.vdb"); }),
                  "in the file's name"));
}

TEST(FramePattern, FindsNumbersThatItWouldWrite) {
  const FramePattern pattern = *FramePattern::of_placeholder("fire.###.vdb");
  EXPECT_EQ(pattern.frame_of("fire.012.vdb"), 12);
  EXPECT_EQ(pattern.frame_of("fire.1012.vdb"), 1012);
  EXPECT_EQ(pattern.frame_of("fire.-12.vdb"), -12);
  EXPECT_EQ(pattern.path(-12), "fire.-12.vdb");
  for (const char* other :
       {"fire.12.vdb", "fire.0012.vdb", "fire.-1.vdb", "fire.012.exr", "fire..vdb"})
    EXPECT_FALSE(pattern.frame_of(other)) << other;
  EXPECT_EQ(pattern.frame_of("fire.20260131120000.vdb"), 20260131120000) << "a time";
  EXPECT_EQ(pattern.path(20260131120000), "fire.20260131120000.vdb");
}

TEST(FramePattern, TheLastNumberOfANameStandsForAny) {
  const FramePattern pattern = *FramePattern::of_number("v2/fire3.0012.vdb");
  EXPECT_EQ(pattern.frame_of("v2/fire3.7.vdb"), 7);
  EXPECT_FALSE(pattern.frame_of("v2/fire4.7.vdb"));
  EXPECT_FALSE(FramePattern::of_number("v2/fire.vdb"));
  // a hyphen behind a letter is none of the number's
  EXPECT_EQ(frame_number("", "v2/fire-0012.vdb"), 12);
  EXPECT_EQ(frame_number("", "v2/fire.-012.vdb"), -12);
  EXPECT_EQ(frame_number("fire.####.v2.vdb", "fire.0012.v2.vdb"), 12);
}

TEST(Frames, AreReadAndWritten) {
  EXPECT_EQ(read_frames("1-10x3,20", "--frames"), (std::vector<FrameNumber>{1, 4, 7, 10, 20}));
  EXPECT_EQ(read_frames("5", "--frames"), (std::vector<FrameNumber>{5}));
  for (const char* text : {"1-10x3,20", "1-2", "4,6", "1-100", "3", "-3-12", "-10--5"})
    EXPECT_EQ(frames_text(read_frames(text, "--frames")), text);
  for (const char* text : {"", "a", "10-1", "1-", "--5", "1-5x0", "5x2"})
    EXPECT_TRUE(has(usage_error([&] { read_frames(text, "--frames"); }),
                    "--frames: expected frames such as"));
  EXPECT_TRUE(has(usage_error([&] { read_frames("0-2000000", "--frames"); }), "more than"));
}

TEST(SequenceFiles, AreThoseOfAPatternAFolderOrNamed) {
  Folder folder;
  const std::string one = folder.file("fire.0001.vdb"), nine = folder.file("fire.0009.vdb"),
                    five = folder.file("fire.0005.vdb");
  for (const std::vector<std::string>& inputs :
       {std::vector{folder.path("fire.####.vdb")}, std::vector{folder.path()},
        std::vector{five, nine, one}})
    EXPECT_EQ(frames_of(sequence_files(inputs).value()), (std::vector<FrameNumber>{1, 5, 9}))
        << inputs[0];
  EXPECT_FALSE(sequence_files(std::vector{one})) << "one file is no sequence";

  const std::string other = folder.file("ash.0001.vdb");
  folder.file("ash.0002.vdb");
  EXPECT_TRUE(has(usage_error([&] { sequence_files(std::vector{folder.path()}); }),
                  "more than one sequence; give one, such as '" + folder.path("ash.####.vdb")));
  const SequenceFiles named = sequence_files(std::vector{one, other}).value();
  EXPECT_EQ(named.at(1), one) << "names that differ otherwise are numbered in their order";
  EXPECT_EQ(named.at(2), other);
  EXPECT_THROW(sequence_files(std::vector{folder.path("ice.####.vdb")}), Error);
}

TEST(SequenceFiles, AreNotHidden) {
  Folder folder;
  // AppleDouble files, as macOS leaves them on other systems' disks
  for (const char* name : {"fire.0001.vdb", "._fire.0001.vdb", "fire.0002.vdb", ".old.0002.vdb"})
    folder.file(name);
  EXPECT_EQ(frames_of(sequence_files(std::vector{folder.path()}).value()),
            (std::vector<FrameNumber>{1, 2}));
}

TEST(SequenceFiles, KnowTheirGaps) {
  EXPECT_EQ(gaps({{1, ""}, {2, ""}, {5, ""}}), (std::vector<FrameNumber>{3, 4}));
  EXPECT_TRUE(gaps({{2, ""}, {4, ""}, {6, ""}}).empty()) << "every second frame";
  EXPECT_TRUE(gaps({{7, ""}}).empty());
  EXPECT_TRUE(gaps({{45, ""}, {50, ""}, {52, ""}}).empty()) << "no step";
  EXPECT_EQ(gaps({{2, ""}, {4, ""}, {8, ""}}), std::vector<FrameNumber>{6});
  EXPECT_TRUE(gaps({{20260131120030, ""}, {20260131120045, ""}, {20260131120100, ""}}).empty())
      << "times";
  EXPECT_TRUE(gaps({{1, ""}, {2, ""}, {99999999, ""}}).empty()) << "no list of so many";
}

/// slab.vdb and blobs.vdb differ in density, place and size.
struct TwoFiles {
  Folder folder;
  std::vector<std::string> paths{folder.file("a.1.vdb", "slab"), folder.file("a.2.vdb", "blobs")};
};

TEST(SequenceScene, LeavesNothingToChoose) {
  TwoFiles files;
  for (const char* look : {"plain", "auto"}) {
    const SequenceScene sequence = resolve_sequence({}, files.paths, look);
    for (const std::string& path : files.paths) {
      const VolumeFile file(path);
      Scene frame = frame_scene(sequence, file, path);
      Scene resolved = make_view(frame, file).scene;
      EXPECT_EQ(to_json(resolved), to_json(frame)) << look << ", " << path;
    }
  }
}

TEST(SequenceScene, HasTheLeastExtinctionAndFramesAll) {
  TwoFiles files;
  const SequenceScene sequence = resolve_sequence({}, files.paths);
  double least = 1e30;
  for (const std::string& path : files.paths) {
    const View own = make_view(Scene{}, VolumeFile(path));
    least = std::min(least, *own.scene.extinction);
    // the common camera has a wide enough view of each subject
    const Camera camera = make_camera(sequence.scene, *own.subject);
    const glm::dvec3 middle = 0.5 * (own.subject->box_min + own.subject->box_max);
    const double ahead = glm::dot(middle - camera.position, camera.forward);
    EXPECT_LT(std::abs(glm::dot(middle - camera.position, camera.right)),
              ahead * camera.half_width);
    EXPECT_LT(std::abs(glm::dot(middle - camera.position, camera.up)), ahead * camera.half_height);
  }
  EXPECT_EQ(*sequence.scene.extinction, least);
}

TEST(SequenceScene, OfOneFileRepeatedIsSeenAsThatFileAlone) {
  Folder folder;
  const std::vector<std::string> paths{folder.file("a.1.vdb", "blobs"),
                                       folder.file("a.2.vdb", "blobs"),
                                       folder.file("a.3.vdb", "blobs")};
  for (const char* look : {"plain", "auto"}) {
    const SequenceScene film = resolve_sequence({}, paths, look);
    const Camera alone = open_scene({}, VolumeFile(paths[0]), {.open_look = look}).view.camera;
    const Camera camera = make_camera(film.scene, *film.subject);
    EXPECT_LT(glm::length(camera.position - alone.position), 1e-9) << look;
    EXPECT_LT(glm::length(camera.target - alone.target), 1e-9) << look;
  }
}

TEST(SequenceScene, TakesTheNearestFileInPlaceOfOneWithoutTheGrid) {
  TwoFiles files;
  files.paths.push_back(files.folder.path("image.nrrd"));
  std::ofstream(files.paths.back())
      << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 1\nencoding: text\n\n5 6\n";
  for (const bool others_serve : {false, true}) {
    const SequenceScene sequence =
        resolve_sequence({}, files.paths, "auto", true, files.paths, others_serve);
    EXPECT_EQ(sequence.scene.grid, "density");
  }
  Scene scene;
  scene.grid = "smoke";  // no file has it
  EXPECT_THROW(resolve_sequence(scene, files.paths, "auto", true, files.paths), Error);
}

TEST(SequenceScene, GoesWithoutTheLooksGridsWhereAFrameLacksThem) {
  Folder folder;
  const std::vector<std::string> paths{folder.file("a.1.vdb", "blobs"),
                                       folder.file("a.2.vdb", "slab")};
  const SequenceScene sequence = resolve_sequence({}, std::span(paths).first(1), "auto");
  EXPECT_EQ(sequence.chosen_grids, (std::vector<std::string>{"emission-grid", "albedo-grid"}));
  const Scene burning = frame_scene(sequence, VolumeFile(paths[0]), paths[0]);
  EXPECT_EQ(burning.emission_grid, "temperature");
  EXPECT_EQ(burning.albedo_grid, "color");
  const Scene plain = frame_scene(sequence, VolumeFile(paths[1]), paths[1]);
  EXPECT_EQ(plain.emission_grid, "");
  EXPECT_EQ(plain.albedo_grid, "");

  Scene scene;
  scene.albedo_grid = "color";
  EXPECT_EQ(chosen_grids(scene, burning), std::vector<std::string>{"emission-grid"});
}

TEST(SequenceScene, GoesWithoutNamedGridsWhereAFrameLacksThemButNotAll) {
  Folder folder;
  const std::vector<std::string> paths{folder.file("a.1.vdb", "slab"),
                                       folder.file("a.2.vdb", "blobs")};
  Scene scene;
  scene.emission_grid = "temperature";
  scene.exposure.reset();  // auto reads every sample
  const SequenceScene sequence = resolve_sequence(scene, paths);
  EXPECT_EQ(sequence.scene.emission_grid, "temperature");
  EXPECT_EQ(frame_scene(sequence, VolumeFile(paths[0]), paths[0]).emission_grid, "");
  EXPECT_EQ(frame_scene(sequence, VolumeFile(paths[1]), paths[1]).emission_grid, "temperature");
  EXPECT_THROW(resolve_sequence(scene, std::span(paths).first(1)), Error);
}

TEST(SequenceScene, HasTheFilesOfAFrameAsFurtherVolumes) {
  Folder folder;
  const std::vector<std::string> paths{folder.file("a.1.vdb", "slab"),
                                       folder.file("a.2.vdb", "slab")};
  folder.file("b.1.vdb", "blobs");
  folder.file("b.2.vdb", "blobs");
  Scene scene;
  const std::string pattern = folder.path("b.#.vdb");
  scene.volumes = {pattern + " scale=0.5"};
  const SequenceScene sequence = resolve_sequence(scene, paths);
  ASSERT_EQ(sequence.scene.volumes.size(), 1u);
  EXPECT_EQ(sequence.scene.volumes[0].find(pattern + " scale=0.5"), 0u);
  const Scene second = frame_scene(sequence, VolumeFile(paths[1]), paths[1]);
  EXPECT_EQ(second.volumes[0].find(folder.path("b.2.vdb") + " scale=0.5"), 0u);
}

TEST(SequenceScene, AsksOneFileIfNothingIsOpen) {
  TwoFiles files;
  const Scene complete = resolve_sequence({}, files.paths).scene;
  std::vector<std::string> paths = files.paths;
  paths.push_back(files.folder.path("not there.vdb"));
  EXPECT_EQ(to_json(resolve_sequence(complete, paths).scene), to_json(complete));
}

TEST(CameraMotion, ATurnKeepsDistanceTargetAndHeight) {
  Scene scene;
  scene.camera_position = glm::dvec3(0, 2, 5);
  scene.camera_target = glm::dvec3(0, 1, 0);
  scene.camera_up = glm::dvec3(0, 1, 0);
  const Scene quarter = turned(scene, 90);
  // to the right: along +X of a camera that looks along -Z
  EXPECT_NEAR(quarter.camera_position->x, 5, 1e-12);
  EXPECT_NEAR(quarter.camera_position->y, 2, 1e-12);
  EXPECT_NEAR(quarter.camera_position->z, 0, 1e-12);
  EXPECT_EQ(quarter.camera_target, scene.camera_target);
}

TEST(CameraMotion, ATurnFramesTheSubjectFromAllSides) {
  const Subject plank = box_subject({-10, -1, -1}, {10, 1, 1});
  const Scene framed = framed_for_turn(Scene{}, plank);
  const double distance = glm::length(*framed.camera_position - *framed.camera_target);
  for (int angle = 0; angle < 360; angle += 15) {
    Scene own;
    own.camera_target = framed.camera_target;
    own.azimuth = angle;
    const Camera camera = make_camera(own, plank);
    EXPECT_LE(glm::length(camera.position - camera.target), distance * (1 + 1e-12)) << angle;
  }
}

TEST(CameraMotion, AFollowingCameraKeepsItsDistanceAndMovesWithTheSubject) {
  View view;
  view.subject = std::make_shared<Subject>(box_subject({9, -1, -1}, {11, 1, 1}));
  const Subject origin = box_subject({-1, -1, -1}, {1, 1, 1});
  view.camera = make_camera(view.scene, origin);
  keep_camera(view.scene, view.camera);
  const View moved = followed(view);
  EXPECT_NEAR(moved.camera.target.x, view.camera.target.x + 10, 1e-9);
  EXPECT_NEAR(moved.camera.position.x, view.camera.position.x + 10, 1e-9);
  EXPECT_NEAR(moved.camera.position.z, view.camera.position.z, 1e-9);
}

std::string path_file(const std::string& text, const std::string& name = "path.json") {
  return test::write_bytes(name, text).string();
}

TEST(CameraPath, EasesBetweenKeysAndHoldsBeyondThem) {
  const std::string file = path_file(R"({"keys": [{"frame": 1, "position": [0,0,0], "fov": 20},
                                         {"frame": 11, "position": [10,0,0], "ease": "linear"},
                                         {"frame": 21, "position": [20,0,0]}]})");
  const CameraPath path = CameraPath::read(file, false, 24);
  const auto x = [&](double frame) { return path.at({}, frame).camera_position->x; };
  EXPECT_EQ(x(-5), 0);
  EXPECT_EQ(x(1), 0);
  EXPECT_NEAR(x(3.5), 10 * (3 * 0.0625 - 2 * 0.015625), 1e-12);  // 3s^2 - 2s^3, s = 1/4
  EXPECT_EQ(x(6), 5);
  EXPECT_EQ(x(13.5), 12.5);
  EXPECT_EQ(x(99), 20);
  EXPECT_EQ(path.at({}, 6).fov, 20) << "only one key sets it";
  EXPECT_FALSE(path.at({}, 6).camera_target) << "no key sets it";
  EXPECT_EQ(path.first(), 1);
  EXPECT_EQ(path.last(), 21);
}

TEST(CameraPath, BadFilesAreRefused) {
  for (const char* text :
       {"", "{}", "[]", R"([{"position": [0,0,0]}])", R"([{"frame": 1, "place": [0,0,0]}])",
        R"([{"frame": 1, "ease": "in"}])", R"([{"frame": 1, "position": [0,0,1]},
                                               {"frame": 1e12, "position": [0,0,1]}])"})
    EXPECT_THROW(CameraPath::read(path_file(text), false, 24), Error) << text;
}

/// Two keys, at 0 and 1 s: translation from (0,0,5) to (4,0,5). The buffer has the floats 0, 1,
/// then the two vectors.
constexpr const char* moving_gltf = R"({"asset": {"version": "2.0"}, "scene": 0,
  "scenes": [{"nodes": [0]}], "nodes": [{"name": "eye", "camera": 0}],
  "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}],
  "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                  "samplers": [{"input": 0, "output": 1}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR"},
                {"bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3"}],
  "bufferViews": [{"buffer": 0, "byteLength": 8}, {"buffer": 0, "byteOffset": 8, "byteLength": 24}],
  "buffers": [{"byteLength": 32, "uri":
    "data:application/octet-stream;base64,AAAAAAAAgD8AAAAAAAAAAAAAoEAAAIBAAAAAAAAAoEA="}]})";

TEST(CameraPath, FollowsAnAnimationOfGltf) {
  const std::string file = path_file(moving_gltf, "path.gltf");
  const CameraPath path = CameraPath::read(file, false, 24);
  EXPECT_EQ(path.last(), 24);
  EXPECT_NEAR(path.at({}, 6).camera_position->x, 1, 1e-6);
  EXPECT_NEAR(path.at({}, 6).camera_position->z, 5, 1e-6);
  EXPECT_NEAR(path.at({}, 99).camera_position->x, 4, 1e-6);
  // Z is up: glTF's Z, towards the viewer, is -Y
  EXPECT_NEAR(CameraPath::read(file, true, 24).at({}, 0).camera_position->y, -5, 1e-6);
  // keys at the frames 1 and 5, whose seconds are rounded to float32
  std::string later = moving_gltf;
  later.replace(later.find("AAAAAAAAgD8A"), 12, "q6oqPVVVVT4A");
  EXPECT_EQ(CameraPath::read(path_file(later, "l.gltf"), false, 24).first(), 1);
  EXPECT_EQ(CameraPath::read(path_file(later, "l.gltf"), false, 24).last(), 5);
  std::string broken = moving_gltf;
  broken.replace(broken.find("\"count\": 2"), 10, "\"count\": 9");
  EXPECT_THROW(CameraPath::read(path_file(broken, "b.gltf"), false, 24), Error);
  broken = moving_gltf;
  broken.replace(broken.find("AAAAAAAAgD8"), 11, "AAAAAAAAwH8");  // a time that is NaN
  EXPECT_THROW(CameraPath::read(path_file(broken, "b.gltf"), false, 24), Error);
}

}  // namespace
}  // namespace psivox
