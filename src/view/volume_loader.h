#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "view/volume.h"

namespace psivox::view {

/// Prepares volumes in a thread of its own; a newer wish replaces an older one.
class VolumeLoader {
 public:
  struct News {
    std::shared_ptr<Volume> volume;  ///< null: none yet
    std::exception_ptr error;        ///< why the last wish was refused
    std::string key;                 ///< of the wish that `volume` or `error` answers
    std::optional<Subject> box;      ///< of the volume in preparation
  };

  /// The thread calls `on_news`.
  explicit VolumeLoader(std::function<void()> on_news);
  ~VolumeLoader();
  VolumeLoader(const VolumeLoader&) = delete;
  VolumeLoader& operator=(const VolumeLoader&) = delete;

  void load(const Scene& scene, const std::vector<std::string>& samples, int generation);
  /// Prepares the volume when there is nothing else to do, and keeps it for a later load.
  void prefetch(const Scene& scene, const std::vector<std::string>& samples, int generation);
  /// Everything new since the last call.
  News news();
  /// Progress of the volume in preparation, see StageProgress; nullopt: there is none.
  std::optional<std::pair<std::string, double>> progress() const;

 private:
  struct Wish {
    Scene scene;
    std::vector<std::string> samples;  ///< of its sequence, see prepare_volume
    int generation = 0;
    std::string key;
  };
  void run(const std::stop_token& stop);
  void prepare(const Wish& wish, bool wanted);

  std::function<void()> on_news_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Wish> wish_, idle_wish_;
  std::uint64_t wishes_ = 0;
  News news_;
  std::optional<std::pair<std::string, double>> progress_;
  std::shared_ptr<const Volume> last_;  ///< the thread's own
  std::shared_ptr<Volume> prefetched_;
  std::jthread thread_;
};

}  // namespace psivox::view
