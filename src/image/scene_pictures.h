#pragma once

#include <memory>
#include <string>

#include "psivox/scene.h"
#include "scene/cuts.h"
#include "scene/environment.h"

// Pictures that a scene names.

namespace psivox {

/// Reads the scene's environment, whose up_axis is known. Throws Error(input) if the file is no
/// latitude-longitude map of finite radiance.
Environment read_environment(const Scene& scene);

/// The holdout that a scene names, kept for the next one that names it.
class NamedHoldout {
 public:
  /// Reads the named layer, else the one that is called Z or depth, or the only one. Throws
  /// Error(input) if there is none or more than one, or if the file has another size than the
  /// picture.
  std::shared_ptr<const Holdout> of(const Scene& scene);

 private:
  std::shared_ptr<const Holdout> kept_;
  std::string name_;
};

}  // namespace psivox
