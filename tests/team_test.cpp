#include "psivox/team.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "blobs_scene.h"
#include "field/value_range.h"
#include "field_voxels.h"
#include "psivox/draw.h"
#include "thread_team.h"
#include "thrown.h"

namespace psivox {
namespace {

using test::in_team;

TEST(Team, AgreeOnAnError) {
  const auto fails_in = [](const std::vector<int>& failing) {
    return in_team(3, [&](const std::shared_ptr<Team>& team) {
      team->agree([&] {
        if (std::ranges::count(failing, team->rank())) throw Error(ExitCode::input, "no file");
        // the others are still at work, which needs all
        team->gather("part");
      });
    });
  };
  const std::vector<std::string> none(3, ""), two(3, "rank 2 of 3, on here: no file");
  EXPECT_EQ(fails_in({}), none);
  EXPECT_EQ(fails_in({2}), two);
  EXPECT_EQ(fails_in({0, 1, 2}), std::vector<std::string>(3, "no file"));
}

TEST(Team, RefuseToDiffer) {
  const auto errors = in_team(3, [](const std::shared_ptr<Team>& team) {
    team->check_same(team->rank() == 1 ? "0.1.1" : "0.1.0", "has another version of psivox");
  });
  EXPECT_EQ(errors,
            std::vector<std::string>(3, "rank 1 has another version of psivox than rank 0"));
}

TEST(Team, OfAMachineTakeItsGpusInTurn) {
  // two machines of 3 ranks, in the order in which mpirun may number them: by machine, or dealt out
  for (const bool dealt : {false, true}) {
    std::vector<std::size_t> taken;
    for (int rank = 0; rank < 6; ++rank)
      taken.push_back(Team::Place{rank, 6, dealt ? rank / 2 : rank % 3, 3, "node"}.in_turn(2));
    EXPECT_EQ(taken, dealt ? (std::vector<std::size_t>{0, 0, 1, 1, 0, 0})
                           : (std::vector<std::size_t>{0, 1, 0, 0, 1, 0}));
  }
}

// Parts are sent as float32, and the strips of 5 ranks have different heights: 9 or 10 rows.
void expect_picture_of_one(const Scene& scene, std::initializer_list<int> counts) {
  const Image alone = Session(scene).draw(*open_double()).image;
  for (const int count : counts) {
    Image together;
    const auto errors = in_team(count, [&](const std::shared_ptr<Team>& team) {
      Session session(scene);
      Wish wish;
      wish.team = team;
      wish.layers.transmittance = true;
      const Image image = session.draw(*open_double(), wish).image;
      if (team->first()) together = image;
    });
    EXPECT_EQ(errors, std::vector<std::string>(std::size_t(count), ""));
    ASSERT_EQ(together.layers.size(), 2u);
    EXPECT_LT(compare_images(alone, together).max, 1e-6) << count << " ranks";
  }
}

TEST(Team, DrawThePictureOfOne) {
  Scene scene = blobs_scene();
  scene.pixel_samples = 2;
  expect_picture_of_one(scene, {1, 2, 5});
  for (const Mode mode : {Mode::mip, Mode::isosurface, Mode::xray}) {
    scene.mode = mode;
    expect_picture_of_one(scene, {3});
  }
  scene.mode = Mode::alpha;
  scene.sampling = Sampling::uniform;
  expect_picture_of_one(scene, {3});
}

// Rays that end behind other members' parts are marched again there. Members without rays wait.
TEST(Team, EndsRaysWhereThoseOfOneEnd) {
  Scene scene = blobs_scene();
  scene.extinction = 30;
  scene.pixel_samples = 2;
  for (const double least : {1e-2, 1.0 / 16384}) {
    scene.early_termination = least;
    expect_picture_of_one(scene, {2, 5});
  }
  scene.zoom = 6;  // no ray sees some of the parts
  expect_picture_of_one(scene, {5});
}

// Depths are sent as float32, 1e-7 of depths of a few; and see above.
TEST(Team, LightThePictureOfOne) {
  Scene scene = blobs_scene();
  scene.lights = {{glm::dvec3(0.3, -1, -0.5), glm::dvec3(1)}};
  expect_picture_of_one(scene, {1, 5});
  // steps begin in one part and end in another; the glow of each voxel is its own
  scene.sampling = Sampling::uniform;
  scene.colormap = Colormap::viridis;
  scene.lights.push_back({glm::dvec3(1, 0.1, 0.2), glm::dvec3(0.2, 0.3, 0.9)});
  expect_picture_of_one(scene, {3});
}

// No method is chosen: the exact one keeps every tolerance.
TEST(Team, KeepATolerance) {
  Scene scene = blobs_scene();
  scene.sampling.reset();
  scene.early_termination.reset();
  scene.tolerance = 1e-4;
  const Image truth = Session(scene).draw(*open_reference()).image;
  const auto errors = in_team(2, [&](const std::shared_ptr<Team>& team) {
    Wish wish;
    wish.team = team;
    const Drawn drawn = Session(scene).draw(*open_double(), wish);
    ASSERT_TRUE(drawn.plan);
    EXPECT_TRUE(drawn.plan->reached);
    EXPECT_EQ(drawn.plan->rays, 0);
    if (team->first()) {
      EXPECT_LT(compare_images(drawn.image, truth).rms, *scene.tolerance);
    }
  });
  EXPECT_EQ(errors, std::vector<std::string>(2, ""));
}

TEST(Team, LightWithinATolerance) {
  Scene scene = blobs_scene();
  scene.lights = {{glm::dvec3(0.3, -1, -0.5), glm::dvec3(1)}};
  const Image truth = Session(scene).draw(*open_double()).image;
  scene.sampling.reset();
  scene.early_termination.reset();
  scene.tolerance = 1e-3;
  const Drawn alone = Session(scene).draw(*open_double());
  const auto errors = in_team(3, [&](const std::shared_ptr<Team>& team) {
    Wish wish;
    wish.team = team;
    const Drawn drawn = Session(scene).draw(*open_double(), wish);
    ASSERT_TRUE(drawn.light);
    EXPECT_EQ(drawn.light->method, alone.light->method);
    EXPECT_GT(drawn.light->rms, 0);
    // of the same points and depths, whose parts are summed in another order and sent as float32
    EXPECT_NEAR(drawn.light->rms, alone.light->rms, 1e-4 * alone.light->rms);
    if (team->first()) {
      EXPECT_LT(compare_images(drawn.image, truth).rms, *scene.tolerance);
    }
  });
  EXPECT_EQ(errors, std::vector<std::string>(3, ""));
}

/// The overview by which a team of two chooses a view, which both have.
Field overview(const Scene& scene) {
  std::array<Field, 2> overviews;
  const auto errors = in_team(2, [&](const std::shared_ptr<Team>& team) {
    const MediumFields fields =
        read_fields(scene, VolumeFile(scene.input), false, {.allowed = true, .team = team});
    EXPECT_TRUE(fields.drawn->reader);
    overviews[std::size_t(team->rank())] = *fields.density;
  });
  EXPECT_EQ(errors, std::vector<std::string>(2, ""));
  EXPECT_EQ(overviews[0].leaves.size(), overviews[1].leaves.size());
  return overviews[1];
}

// All members choose by the same overview: of few leaves the density itself, of many every eighth
// of its voxels.
TEST(Team, ChooseByAnOverview) {
  Scene scene = blobs_scene();
  const Field whole = VolumeFile(scene.input).read("density");
  const Field same = overview(scene);
  ASSERT_EQ(same.leaves.size(), whole.leaves.size());
  for (std::size_t n = 0; n < whole.leaves.size(); ++n) {
    EXPECT_EQ(same.leaves[n].origin, whole.leaves[n].origin);
    EXPECT_TRUE(std::ranges::equal(std::span(same.leaves[n].values, 512),
                                   std::span(whole.leaves[n].values, 512)));
  }
  EXPECT_EQ(active_range(same), active_range(whole));
  EXPECT_EQ(same.active_box, whole.active_box);
  scene.memory_limit = whole.leaves.size() * 4096;
  const Field coarse = overview(scene);
  EXPECT_LE(coarse.leaves.size(), whole.leaves.size() / 2);
  EXPECT_EQ(active_range(coarse), active_range(whole));
  const FieldVoxels voxels(whole);
  for (const Leaf& leaf : coarse.leaves)
    for (int i = 0; i < 512; ++i) {
      const glm::ivec3 voxel = leaf.origin + glm::ivec3(i >> 6, (i >> 3) & 7, i & 7);
      bool is_one_of_eight = false;
      for (int k = 0; k < 8; ++k)
        is_one_of_eight |=
            voxels(2 * voxel + glm::ivec3(k >> 2, k >> 1 & 1, k & 1)).x == leaf.values[i];
      ASSERT_TRUE(is_one_of_eight);
    }
}

TEST(Team, SayWhatTheyCannotDraw) {
  Scene scene = blobs_scene();
  const auto errors = in_team(2, [&](const std::shared_ptr<Team>& team) {
    Session session(scene);
    Wish wish;
    wish.team = team;
    wish.layers.depth = true;
    session.draw(*open_double(), wish);
  });
  EXPECT_TRUE(has(errors[0], "without other layers"));
  EXPECT_EQ(errors[0], errors[1]);
}

}  // namespace
}  // namespace psivox
