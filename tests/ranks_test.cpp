#include "psivox/ranks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <barrier>
#include <cstdlib>
#include <mutex>
#include <thread>

#include "blobs_scene.h"
#include "psivox/draw.h"

namespace psivox {
namespace {

/// What the ranks of one process share.
struct Exchange {
  explicit Exchange(int count) : met(count), texts(std::size_t(count)) {}
  std::barrier<> met;
  std::vector<std::string> texts;
  std::vector<std::vector<float>> floats{texts.size()};
  std::vector<std::vector<std::vector<glm::vec4>>> pixels{texts.size()};
  std::vector<double> reports = std::vector<double>(texts.size());
  std::mutex reporting;
};

/// A rank that is a thread.
class ThreadRank final : public Ranks {
 public:
  ThreadRank(Exchange& shared, int rank)
      : Ranks({rank, int(shared.texts.size()), 0, 1, "here"}), shared_(shared) {}

  std::vector<std::vector<glm::vec4>> exchange(
      const std::vector<std::vector<glm::vec4>>& to) override {
    const auto all = meet(shared_.pixels, to);
    std::vector<std::vector<glm::vec4>> received;
    for (const auto& from : all) received.push_back(from[std::size_t(rank())]);
    return received;
  }
  std::vector<std::vector<float>> collect(const std::vector<float>& part) override {
    const auto all = meet(shared_.floats, part);
    return first() ? all : std::vector<std::vector<float>>{};
  }
  void report(double fraction) override {
    const std::lock_guard lock(shared_.reporting);
    shared_.reports[std::size_t(rank())] = fraction;
  }
  Reported reported() override {
    const std::lock_guard lock(shared_.reporting);
    return {*std::ranges::min_element(shared_.reports), 0.5};
  }
  void abort(int) override { std::abort(); }
  void finish() override {}

 protected:
  std::vector<std::string> all_gather(const std::string& bytes) override {
    return meet(shared_.texts, bytes);
  }

 private:
  template <typename T>
  std::vector<T> meet(std::vector<T>& all, const T& own) {
    all[std::size_t(rank())] = own;
    shared_.met.arrive_and_wait();
    std::vector<T> result = all;
    shared_.met.arrive_and_wait();
    return result;
  }

  Exchange& shared_;
};

/// Does work in so many ranks. Returns the error that each has agreed to, or "".
std::vector<std::string> on_ranks(int count,
                                  const std::function<void(std::shared_ptr<Ranks>)>& work) {
  Exchange shared(count);
  std::vector<std::string> errors(std::size_t(count), "");
  std::vector<std::jthread> threads;
  for (int rank = 0; rank < count; ++rank)
    threads.emplace_back([&, rank] {
      try {
        work(std::make_shared<ThreadRank>(shared, rank));
      } catch (const AgreedError& error) {
        errors[std::size_t(rank)] = error.what();
      }
    });
  threads.clear();
  return errors;
}

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
TEST(Ranks, DrawThePictureOfOne) {
  Scene scene = blobs_scene();
  scene.pixel_samples = 2;
  const Image alone = Session(scene).draw(*open_double()).image;
  for (const int count : {1, 2, 5}) {
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
