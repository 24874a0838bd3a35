// A film with a fire in some of its frames is one of fire, whichever of them chooses.

#include "march_cases.h"
#include "psivox/draw.h"
#include "psivox/open.h"
#include "psivox/sequence.h"
#include "thrown.h"
#include "vdb_zoo_grids.h"

namespace psivox {
namespace {

using namespace test;

/// A frame whose flame is that much of the zoo's; 0: its grid has zeros, below 0: no voxel.
std::string frame(const std::string& name, double burning) {
  const auto glow = burning < 0
                        ? named("flame")
                        : filled("flame", [=](const Coord& p) { return burning * flame(p); });
  if (burning == 0) glow->fill(CoordBBox(Coord(-13), Coord(13)), 0.0f, true);
  return write_vdb({filled("density", cloud), glow}, name + ".vdb").string();
}

/// A film, as its files by their frames.
SequenceFiles film(const std::string& name, std::initializer_list<double> frames) {
  SequenceFiles files;
  for (const double burning : frames) {
    const int number = int(files.size()) + 1;
    files[number] = frame(name + "." + std::to_string(number), burning);
  }
  return files;
}

SequenceScene chosen_for(const SequenceFiles& files, Scene scene = {}) {
  scene.resolution = {96, 54};
  return resolve_sequence(scene, auto_samples(files), "auto");
}

/// The greatest excess of red over blue.
double redness(const SequenceScene& sequence, const std::string& path) {
  const VolumeFile file(path);
  const Scene scene = frame_scene(sequence, file, path);
  const Image image =
      Session(make_view(scene, read_fields(scene, file, true))).draw(*open_double()).image;
  double most = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      most = std::max(most, double(pixel(image, x, y, 0)) - double(pixel(image, x, y, 2)));
  return most;
}

/// A frame with a ball of smoke of 4 voxels around a place.
std::string puff(const std::string& name, const Coord& middle, int domain = 0) {
  const auto grid = named("density");
  for (int x = -4; x <= 4; ++x)
    for (int y = -4; y <= 4; ++y)
      for (int z = -4; z <= 4; ++z)
        if (x * x + y * y + z * z <= 16) grid->tree().setValue(middle.offsetBy(x, y, z), 1.0f);
  if (domain > 0) {
    grid->insertMeta("file_base_resolution", openvdb::Vec3IMetadata({domain, domain, domain / 2}));
    grid->setTransform(openvdb::math::Transform::createLinearTransform(1.0 / domain));
  }
  return write_vdb({grid}, name).string();
}

bool is_seen(const SequenceScene& film, const std::string& path) {
  const View own = open_frame(film, VolumeFile(path), path).view;
  const glm::dvec3 way = 0.5 * (own.subject->box_min + own.subject->box_max) - own.camera.position;
  const double ahead = glm::dot(way, own.camera.forward);
  return std::abs(glm::dot(way, own.camera.right)) < ahead * own.camera.half_width &&
         std::abs(glm::dot(way, own.camera.up)) < ahead * own.camera.half_height;
}

TEST(Film, IsSeenWhole) {
  // neither the first, the middle nor the last goes so far
  std::vector<std::string> paths;
  for (const int height : {0, 90, 10, 20, 5, 0, 0})
    paths.push_back(
        puff("rise." + std::to_string(paths.size()) + ".vdb", Coord(height / 9, height, 0)));
  const std::vector<std::string> samples{paths[0], paths[3], paths[6]};
  const auto film = [&](Headers headers) {
    return resolve_sequence({}, samples, "auto", true, paths, false, headers);
  };
  for (const std::string& path : paths) EXPECT_TRUE(is_seen(film(Headers::seen), path)) << path;
  EXPECT_FALSE(is_seen(film(Headers::placed), paths[1]));
}

TEST(Film, OfADomainThatAdaptsHasVoxelsOfOneSize) {
  std::vector<std::string> paths;
  for (const int domain : {16, 40, 24})
    paths.push_back(puff("adapts." + std::to_string(domain) + ".vdb",
                         Coord(domain / 2, domain / 2, 5), domain));
  const SequenceScene film = resolve_sequence({}, paths, "auto");
  ASSERT_EQ(film.notices.size(), 1u);
  EXPECT_TRUE(has(film.notices[0], "domain adapts"));
  const View first = open_frame(film, VolumeFile(paths[0]), paths[0]).view;
  for (const std::string& path : paths) {
    const View view = open_frame(film, VolumeFile(path), path).view;
    EXPECT_NEAR(glm::length(glm::dvec3(view.medium.density->world_from_index[0])), 1.0 / 40, 1e-12);
    EXPECT_LT(glm::length(view.subject->box_min - first.subject->box_min), 1e-12) << path;
    EXPECT_LT(glm::length(view.subject->box_max - first.subject->box_max), 1e-12) << path;
  }
  // a domain that stays is none that adapts
  EXPECT_FALSE(resolve_sequence({}, std::vector{paths[0], paths[0]}, "auto").adaptive);
}

TEST(Film, WithAFlameInAnyFrameIsOfFire) {
  // neither the first, the middle nor the last burns
  const SequenceFiles files = film("rare", {-1, 0.02, 0, 1, -1});
  const SequenceScene sequence = chosen_for(files);
  EXPECT_EQ(sequence.look, "fire");
  EXPECT_GT(redness(sequence, files.at(4)), 1);
  for (const int dark : {1, 3, 5}) EXPECT_LT(redness(sequence, files.at(dark)), 0.1) << dark;
}

TEST(Film, IsAsBrightAsItsBrightestFlame) {
  const SequenceFiles one = film("one", {1});
  const double alone = chosen_for(one).scene.emission_scale;
  const SequenceFiles files = film("more", {-1, 0, 1, 0.02, 1e-9});
  EXPECT_NEAR(chosen_for(files).scene.emission_scale / alone, 1, 1e-9);
  // thick smoke hides most of the flame, and what is left is bright
  Scene thick;
  thick.extinction = 100;
  EXPECT_GT(redness(chosen_for(one, thick), one.at(1)), 0.5);
}

TEST(Film, IsChosenByItsHottestFlameAndItsLargest) {
  SequenceFiles files;
  for (const auto& [value, radius] : {std::pair(0.1, 1), {9.0, 1}, {1.0, 2}, {1.0, 1}, {0.5, 3}}) {
    const int number = int(files.size()) + 1;
    const auto burns = [value = value](const Coord&) { return value; };
    files[number] = write_vdb({filled("density", cloud), filled("flame", burns, radius)},
                              "blast." + std::to_string(number) + ".vdb")
                        .string();
  }
  const std::vector<std::string> all{files.at(1), files.at(2), files.at(3), files.at(5)};
  EXPECT_EQ(auto_samples(files), all);
}

LookedScene look_of(const openvdb::GridCPtrVec& grids) {
  Scene scene;
  scene.input = write_vdb(grids, "look.vdb").string();
  return with_look(scene, VolumeFile(scene.input), "auto");
}

TEST(Fire, OfAFlameAloneHasNoSmoke) {
  const Scene scene = look_of({filled("flame", flame)}).scene;
  EXPECT_EQ(scene.emission_grid, "flame");
  EXPECT_EQ(scene.extinction, 0);
  const Scene grey = look_of({filled("temperature", flame)}).scene;
  EXPECT_EQ(grey.emission_grid, "");
}

TEST(Fire, IsNoHeatThatDoesNotGlow) {
  const auto hot = [](const char* name, double most) {
    return filled(name, [=](const Coord& p) { return most * flame(p); });
  };
  const auto smoke = filled("density", cloud);
  for (const double most : {1.0, 1e4}) {
    EXPECT_EQ(look_of({smoke, hot("temperature", most)}).look, "fire") << most;
    EXPECT_EQ(look_of({smoke, hot("flame", most)}).look, "fire") << most;
  }
  // a warm gas in kelvin; a flame is one in any unit
  EXPECT_EQ(look_of({smoke, hot("temperature", 700)}).look, "smoke");
  EXPECT_LT(look_of({smoke, hot("flame", 700)}).scene.temperature_scale, 3000 / 100.0);
  // Blender's heat drives the smoke, and what burns there has a flame
  EXPECT_EQ(look_of({smoke, hot("heat", 1)}).look, "fire");
  const auto shadow = named("shadow");
  EXPECT_EQ(look_of({smoke, hot("heat", 1), shadow}).look, "smoke");
  EXPECT_EQ(look_of({smoke, hot("heat", 1), hot("flame", 1), shadow}).look, "fire");
}

TEST(FurtherVolumes, ThatLieOnTheirSideAreNamed) {
  const auto smoke = filled("density", cloud);
  Scene scene;
  scene.input = write_vdb({smoke}, "first.vdb").string();
  const std::string second = write_vdb({smoke, named("shadow")}, "second.vdb").string();
  for (const char* turn : {"", " rotate=-90,0,0"}) {
    scene.volumes = {second + turn};
    const OpenedScene opened = open_scene(scene, VolumeFile(scene.input));
    const std::vector<std::string> notices = notices_of(opened.view);
    EXPECT_EQ(std::ranges::any_of(notices, [](auto& n) { return n.find("Z is up") != n.npos; }),
              *turn == 0);
  }
}

TEST(Luminance, BesideLightIsTakenAtTheDensitysVoxels) {
  const auto glow = filled("glow", cloud);
  glow->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  Scene scene;
  scene.input = write_vdb({filled("density", cloud), glow}, "two.vdb").string();
  scene.luminance_grid = "glow";
  const auto notices = [&] {
    return read_fields(scene, VolumeFile(scene.input)).luminance->notices;
  };
  EXPECT_TRUE(notices().empty());
  scene.lights = {{{0, -1, 0}, glm::dvec3(1)}};
  EXPECT_TRUE(has(notices().back(), "at the density's voxels"));
}

TEST(Film, WithoutAFlameIsOfSmoke) {
  const SequenceScene sequence = chosen_for(film("smoke", {-1, 0, 1e-9}));
  EXPECT_EQ(sequence.look, "smoke");
  EXPECT_TRUE(sequence.scene.emission_grid.empty());
}

}  // namespace
}  // namespace psivox
