#pragma once

#include <memory>
#include <optional>
#include <string>

#include "view/volume_loader.h"

namespace psivox::view {

/// The volume that the window shows, and the loading of the next one. A volume that cannot be
/// loaded leaves the old one.
class CurrentVolume {
 public:
  struct News {
    bool box_known = false;    ///< of the first volume: box() has it
    bool arrived = false;      ///< get() is a new volume
    bool first = false;        ///< and the first one
    std::exception_ptr error;  ///< why the wish was refused
  };

  /// Another thread calls `on_news`.
  explicit CurrentVolume(std::function<void()> on_news) : loader_(std::move(on_news)) {}

  const std::shared_ptr<Volume>& get() const { return volume_; }
  /// Loads the scene's volume, a frame of the sequence with these samples, unless it is there. True
  /// if it is there.
  bool wish(const Scene& scene, const std::vector<std::string>& samples);
  /// Prepares a volume that is likely to be the next.
  void prefetch(const Scene& scene, const std::vector<std::string>& samples) {
    loader_.prefetch(scene, samples, generation_);
  }
  /// The next wish reads the file again.
  void reload();
  /// The next wish is tried even if it was refused before.
  void retry() { refused_key_.clear(); }
  /// Everything new since the last call.
  News take_news();
  /// The window cannot show the volume that has arrived.
  void refuse() { refused_key_ = volume_->key; }

  bool loading() const { return awaited_key_.has_value(); }
  /// Stage of the loading, and how much of it is done; 0: not known.
  std::optional<std::pair<std::string, double>> progress() const { return loader_.progress(); }
  /// Box of the first volume while it is loading.
  const std::optional<Subject>& box() const { return box_; }

 private:
  VolumeLoader loader_;
  std::shared_ptr<Volume> volume_;
  int generation_ = 0;                      ///< of reloads
  std::optional<std::string> awaited_key_;  ///< of the volume in preparation
  std::string refused_key_;                 ///< of the wish that was refused
  std::optional<Subject> box_;
};

}  // namespace psivox::view
