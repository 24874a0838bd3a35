// A film with a fire in some of its frames is one of fire, whichever of them chooses.

#include "march_cases.h"
#include "psivox/draw.h"
#include "psivox/sequence.h"
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
  const VdbFile file(path);
  const Scene scene = frame_scene(sequence, file, path);
  const Image image =
      Session(make_view(scene, read_fields(scene, file, true))).draw(*open_double()).image;
  double most = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      most = std::max(most, double(pixel(image, x, y, 0)) - double(pixel(image, x, y, 2)));
  return most;
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

TEST(Film, WithoutAFlameIsOfSmoke) {
  const SequenceScene sequence = chosen_for(film("smoke", {-1, 0, 1e-9}));
  EXPECT_EQ(sequence.look, "smoke");
  EXPECT_TRUE(sequence.scene.emission_grid.empty());
}

}  // namespace
}  // namespace psivox
