#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "view/volume.h"

namespace psivox::view {

/// The volume that the window shows, and the thread that prepares the next one. A newer wish
/// replaces an older one. A volume that cannot be loaded leaves the old one.
class CurrentVolume {
 public:
  struct News {
    bool box_known = false;    ///< of the first volume: box() has it
    bool arrived = false;      ///< get() is a new volume
    bool first = false;        ///< and the first one
    std::exception_ptr error;  ///< why the wish was refused
  };

  /// The thread calls `on_news`.
  explicit CurrentVolume(std::function<void()> on_news);
  ~CurrentVolume();

  const std::shared_ptr<Volume>& get() const { return volume_; }
  /// Loads the scene's volume, a frame of the sequence with these samples, unless it is there. True
  /// if it is there.
  bool wish(const Scene& scene, const std::vector<std::string>& samples);
  /// Prepares a volume that is likely to be the next when there is nothing else to do.
  void prefetch(const Scene& scene, const std::vector<std::string>& samples);
  /// The next wish reads the file again.
  void reload();
  /// The next wish is tried even if it was refused before.
  void retry() { refused_key_.clear(); }
  /// Everything new since the last call.
  News take_news();
  /// The window cannot show the volume that has arrived.
  void refuse() { refused_key_ = volume_->key; }

  bool loading() const { return awaited_key_.has_value(); }
  /// Stage of the loading, and how much of it is done, see StageProgress; nullopt: there is none.
  std::optional<std::pair<std::string, double>> progress() const;
  /// Box of the first volume while it is loading.
  const std::optional<Subject>& box() const { return box_; }

 private:
  struct Wish {
    Scene scene;
    std::vector<std::string> samples;  ///< of its sequence, see prepare_volume
    int generation = 0;
    std::string key;
  };
  /// What the thread has done for the newest wish since it was last asked.
  struct Done {
    std::shared_ptr<Volume> volume;  ///< null: none yet
    std::exception_ptr error;        ///< why the wish was refused
    std::string key;                 ///< of the wish; empty: neither `volume` nor `error` is there
    std::optional<Subject> box;      ///< of the volume in preparation
  };
  /// Changes what the thread is to do, and wakes it.
  void post(const std::function<void()>& change);
  void run(const std::stop_token& stop);
  /// Works until `wishes_` differs from `number`.
  void prepare(const Wish& wish, bool wanted, std::uint64_t number);

  // the window's
  std::shared_ptr<Volume> volume_;
  int generation_ = 0;                      ///< of reloads
  std::optional<std::string> awaited_key_;  ///< of the volume in preparation
  std::string refused_key_;                 ///< of the wish that was refused
  std::optional<Subject> box_;

  std::function<void()> on_news_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Wish> wish_, idle_wish_;
  std::uint64_t wishes_ = 0;  ///< counts them, and the end of one
  Done done_;
  std::optional<std::pair<std::string, double>> progress_;
  std::shared_ptr<const Volume> last_;  ///< the thread's own
  std::shared_ptr<Volume> prefetched_;
  std::jthread thread_;
};

}  // namespace psivox::view
