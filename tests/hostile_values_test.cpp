// Values that a stranger's file may have, through looks, functions, light and every mode, by the
// march in double and the reference: no index, sum or conversion of them is undefined, which the
// sanitizers of .ci/run look for, and each pixel is a number. (A sky takes a minute a picture under
// them.)

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/open.h"
#include "psivox/parameters.h"
#include "psivox/vdb.h"

namespace psivox {
namespace {

constexpr float most = std::numeric_limits<float>::max();

/// A ball of values up to 1 in surroundings of one value; one voxel of sixteen is one of `bad`.
std::shared_ptr<const VolumeFile> ball_with(const std::vector<float>& bad, float around) {
  constexpr int across = 10;
  std::mt19937 random(7);
  std::vector<float> values;
  DenseField made("values", glm::ivec3(across), 1, glm::dmat4(1));
  for (int x = 0; x < across; ++x)
    for (int y = 0; y < across; ++y)
      for (int z = 0; z < across; ++z) {
        const glm::dvec3 p = glm::dvec3(x, y, z) / (0.5 * (across - 1)) - 1.0;
        const bool replaced = random() % 16 == 0;
        const double inside = 1 - glm::dot(p, p);
        values.push_back(replaced     ? bad[random() % bad.size()]
                         : inside > 0 ? float(inside)
                                      : around);
      }
  for (int x = 0; x < across; x += 8) {
    const auto slab = std::ptrdiff_t(x) * across * across;
    const auto size = std::ptrdiff_t(std::min(8, across - x)) * across * across;
    made.add({values.begin() + slab, values.begin() + slab + size});
  }
  return std::make_shared<VolumeFile>(std::make_shared<const Field>(made.finish()));
}

using Settings = std::vector<Setting>;

/// Draws what these settings say of a file, as `render` does.
void expect_numbers(const VolumeFile& file, const Settings& settings, Marcher& marcher) {
  Scene scene;
  scene.resolution = {4, 4};
  for (const Setting& setting : settings) set_parameter(scene, setting.name, setting.text);
  SCOPED_TRACE(to_json(scene));
  try {
    const LookedScene looked = with_look(scene, file, "auto");
    Session session(make_view(looked.scene, looked.fields));
    const Drawn drawn = session.draw(marcher);
    EXPECT_TRUE(std::ranges::all_of(drawn.image.rgba(), [](float v) { return std::isfinite(v); }));
  } catch (const Error& error) {  // that a value cannot be drawn is one line
    EXPECT_NE(error.code(), ExitCode::usage) << error.what();
  }
}

TEST(HostileValues, AreDrawnAsNumbers) {
  const std::vector<std::vector<float>> hostile = {
      {-most},     {most},   {5e37f},       {std::nanf("")},
      {-INFINITY}, {1e-45f}, {0.1f, 1e38f}, {most, -most, std::nanf(""), 16777217.0f}};
  const std::vector<Settings> cases = {
      {},
      {{"look", "plain"}},
      {{"look", "smoke"}, {"tolerance", "1e-2"}},
      {{"look", "scan"}, {"texel", "code7"}},
      {{"look", "labels"}},
      {{"look", "signed"}},
      {{"look", "plain"}, {"colormap", "viridis"}, {"range", "5%,95%"}, {"light", "0,-1,0"}},
      {{"look", "plain"}, {"luminance", "0,0,0"}, {"light", "camera:1,1,1"}},
      {{"look", "plain"}, {"opacity", "0:0,1:1"}, {"integrator", "preintegrated"}, {"step", "2"}},
      {{"look", "plain"}, {"opacity", "0:1,1:0"}, {"fill-value", "none"}},
      {{"look", "plain"}, {"colormap", "gray"}, {"classification", "pre"}},
      {{"look", "plain"}, {"integrator", "psi-table"}},
      {{"value-scale", "symlog"}},
      {{"mode", "mip"}},
      {{"mode", "mean"}},
      {{"mode", "isosurface"}},
      {{"mode", "slice"}, {"colormap", "inferno"}},
      {{"mode", "xray"}}};
  const std::vector<std::shared_ptr<Marcher>> marchers{open_double(), open_reference()};
  for (std::size_t i = 0; i < hostile.size(); ++i) {
    const auto file = ball_with(hostile[i], i % 2 ? hostile[i].front() : 0);
    for (const Settings& settings : cases)
      for (const auto& marcher : marchers) expect_numbers(*file, settings, *marcher);
  }
}

}  // namespace
}  // namespace psivox
