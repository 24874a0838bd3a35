#include "psivox/ranks.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "blobs_scene.h"
#include "psivox/draw.h"
#include "thread_ranks.h"

namespace psivox {
namespace {

using test::on_ranks;

TEST(Ranks, AgreeOnAnError) {
  const auto fails_in = [](const std::vector<int>& failing) {
    return on_ranks(3, [&](const std::shared_ptr<Ranks>& ranks) {
      ranks->agree([&] {
        if (std::ranges::count(failing, ranks->rank())) throw Error(ExitCode::input, "no file");
        // the others are still at work, which needs all
        ranks->gather("part");
      });
    });
  };
  const std::vector<std::string> none(3, ""), two(3, "rank 2 of 3, on here: no file");
  EXPECT_EQ(fails_in({}), none);
  EXPECT_EQ(fails_in({2}), two);
  EXPECT_EQ(fails_in({0, 1, 2}), std::vector<std::string>(3, "no file"));
}

TEST(Ranks, RefuseToDiffer) {
  const auto errors = on_ranks(3, [](const std::shared_ptr<Ranks>& ranks) {
    ranks->check_same(ranks->rank() == 1 ? "0.1.1" : "0.1.0", "has another version of psivox");
  });
  EXPECT_EQ(errors,
            std::vector<std::string>(3, "rank 1 has another version of psivox than rank 0"));
}

// Parts are sent as float32, and the strips of 5 ranks have different heights: 9 or 10 rows.
void expect_picture_of_one(const Scene& scene, std::initializer_list<int> counts) {
  const Image alone = Session(scene).draw(*open_double()).image;
  for (const int count : counts) {
    Image together;
    const auto errors = on_ranks(count, [&](const std::shared_ptr<Ranks>& ranks) {
      Session session(scene);
      Wish wish;
      wish.ranks = ranks;
      wish.layers.transmittance = true;
      const Image image = session.draw(*open_double(), wish).image;
      if (ranks->first()) together = image;
    });
    EXPECT_EQ(errors, std::vector<std::string>(std::size_t(count), ""));
    ASSERT_EQ(together.layers.size(), 2u);
    EXPECT_LT(compare_images(alone, together).max, 1e-6) << count << " ranks";
  }
}

TEST(Ranks, DrawThePictureOfOne) {
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

// No method is chosen: the exact one keeps every tolerance.
TEST(Ranks, KeepATolerance) {
  Scene scene = blobs_scene();
  scene.sampling.reset();
  scene.early_termination.reset();
  scene.tolerance = 1e-4;
  const Image truth = Session(scene).draw(*open_reference()).image;
  const auto errors = on_ranks(2, [&](const std::shared_ptr<Ranks>& ranks) {
    Wish wish;
    wish.ranks = ranks;
    const Drawn drawn = Session(scene).draw(*open_double(), wish);
    ASSERT_TRUE(drawn.plan);
    EXPECT_TRUE(drawn.plan->reached);
    EXPECT_EQ(drawn.plan->rays, 0);
    if (ranks->first()) {
      EXPECT_LT(compare_images(drawn.image, truth).rms, *scene.tolerance);
    }
  });
  EXPECT_EQ(errors, std::vector<std::string>(2, ""));
}

TEST(Ranks, SayWhatTheyCannotDraw) {
  Scene scene = blobs_scene();
  scene.lights = {{glm::dvec3(0.3, -1, -0.5), glm::dvec3(1)}};
  const auto errors = on_ranks(2, [&](const std::shared_ptr<Ranks>& ranks) {
    Session session(scene);
    Wish wish;
    wish.ranks = ranks;
    session.draw(*open_double(), wish);
  });
  EXPECT_NE(errors[0].find("without light"), std::string::npos);
  EXPECT_EQ(errors[0], errors[1]);
}

}  // namespace
}  // namespace psivox
