// Random events, for races and for memory: under ThreadSanitizer the window's threads are watched
// (the loader, the pictures' thread, the saver), in the preset `dev` AddressSanitizer watches all.

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "scratch.h"
#include "view/benchmark.h"
#include "viewer_hands.h"

namespace psivox::view {
namespace {

/// A hand without a plan.
class RandomHands {
 public:
  RandomHands(Hands& hands, unsigned seed) : hands_(hands), random_(seed) {
    for (const char* name : {"blobs", "slab", "rotated", "tiles", "single_voxel", "ramp"})
      files_.push_back(asset(name) + ".vdb");
    files_.push_back(asset("shells.json"));  // which is none
  }

  void act() {
    switch (below(12)) {
      case 0:
        return hands_.drop(files_[below(files_.size())]);
      case 1:
        return hands_.drag(place(), place(), int(below(3)));
      case 2:
        return hands_.post({Kind::wheel, {0, below(2) ? 1 : -1}});
      case 3:
        if (below(5) == 0 && !hands_.viewer.saving())
          hands_.viewer.messages().attempt([&] { hands_.viewer.save_picture("saved.png"); });
        return;
      case 4:
        return hands_.key(GLFW_KEY_1 + int(below(7)));
      case 5:
        return hands_.viewer.show(ShownLayer(below(4)));
      case 6:
        return hands_.viewer.choose_look(below(2) ? "smoke" : "plain");
      case 7:
        if (below(5) == 0)
          hands_.viewer.window().resize({300 + int(below(200)), 200 + int(below(200))});
        return;
      case 8:
        hands_.viewer.panels().transfer = below(2);
        return;
      default:
        hands_.frames(int(below(6)));
    }
  }

 private:
  std::size_t below(std::size_t n) { return random_() % n; }
  glm::dvec2 place() { return {double(below(480)), double(below(360))}; }

  Hands& hands_;
  std::mt19937 random_;
  std::vector<std::string> files_;
};

/// 400 events; PSIVOX_EVENTS sets another number, and is the seed.
TEST(ViewerEvents, HarmNothing) {
  const char* wanted = std::getenv("PSIVOX_EVENTS");
  const int events = wanted ? std::atoi(wanted) : 400;
  const fs::path before = fs::current_path();
  const fs::path folder = test::scratch_dir();
  fs::current_path(folder);  // some hit the button that saves the transfer function
  Hands hands(small(asset("blobs.vdb")));
  hands.errors.reset();
  RandomHands random(hands, unsigned(events));
  for (int n = 0; n < events; ++n) random.act();
  ASSERT_TRUE(hands.until([&] { return !hands.viewer.saving(); }));
  hands.viewer.compare(Comparison::none, {});
  hands.viewer.show(ShownLayer::picture);
  hands.drop(asset("slab.vdb"));
  hands.frames(3);
  hands.expect_rendered();
  fs::current_path(before);
}

}  // namespace
}  // namespace psivox::view
