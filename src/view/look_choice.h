#pragma once

#include <functional>
#include <string>
#include <vector>

#include "view/volume.h"

namespace psivox::view {

/// The look of what the window shows, and what it set.
class LookChoice {
 public:
  /// Of a scene as the program was started with it: its look, or `auto` if it leaves its look open.
  explicit LookChoice(const Scene& start);

  /// Has the scene ask for the look of the start, without what the last look has set. What the user
  /// has changed since then stays.
  void start_again(Scene& scene);
  /// Has the scene ask for a look, in place of all that it says of how a picture looks.
  void choose(const std::string& name, Scene& scene);
  /// Takes what a volume's look has chosen over to the scene that asked for it, except what the
  /// user has changed meanwhile. Returns what to tell the user; empty: nothing.
  std::string take(const Volume& volume, Scene& scene);
  /// Has the scene name what `auto` chose for the volume, so that it counts for other frames too.
  void hold(const Volume& volume, Scene& scene);

  /// `smoke`, `auto: smoke`
  std::string text() const;

 private:
  void ask(const std::string& name, Scene& scene);
  void take_back(Scene& scene, bool camera);

  std::string start_, name_;
  std::string chosen_;            ///< by `auto`
  std::vector<std::string> set_;  ///< parameters that were chosen
  Scene set_scene_;               ///< with their values
};

}  // namespace psivox::view
