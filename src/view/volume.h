#pragma once

#include <array>
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

#include "field/field_index.h"
#include "psivox/draw.h"
#include "psivox/open.h"
#include "psivox/picture_file.h"
#include "psivox/vdb.h"
#include "scene/transfer_function.h"

namespace psivox::view {

/// How often each value occurs among the density's leaves and tiles, without its zeros.
struct Histogram {
  double min = 0, max = 1;
  std::array<double, 128> counts{};
};

/// A scene's file, read and converted. The session belongs to the thread that draws, once it has
/// the volume. The rest does not change.
struct Volume {
  Scene asked;  ///< for which it was prepared
  Scene scene;  ///< to draw
  /// Set if a look was asked for or a sequence leaves something open: what was chosen. The window
  /// shows its scene from now on, for the other frames too.
  std::optional<LookedScene> chosen;
  std::size_t chosen_from = 1;            ///< frames
  std::vector<std::string> chosen_grids;  ///< by a look; other frames may lack them
  Scene resolved;                         ///< `scene` with nothing left open
  std::string key;                        ///< of the scene that the window shows
  MediumFields fields;
  std::string fields_key;
  std::vector<std::string> grids;  ///< names of the file's, as --grid takes them
  std::shared_ptr<const Subject> subject;
  double extinction = 1;  ///< resolved
  Histogram histogram;
  std::shared_ptr<const TransferFunction> function;  ///< of the density; null: none
  std::vector<std::string> notices;

  std::optional<ColorScale> colors;  ///< of the values, if they have any

  std::unique_ptr<Session> session;

  /// The density's value at a point of the world, as the file has it.
  double value_at(const glm::dvec3& point) const;

 private:
  mutable std::unique_ptr<const FieldIndex> index_;  ///< of the thread that asks for values
};

/// The parameters that a scene's volume depends on, as text; `generation` counts reloads of its
/// files. Scenes of one key differ in camera, march and picture only.
std::string volume_key(const Scene& scene, int generation);

/// How far preparing is: what is being done, and how much of that is; 0: not known.
using StageProgress = std::function<void(const std::string& stage, double fraction)>;

/// Called with what the camera frames, before the conversion.
using SubjectKnown = std::function<void(const std::shared_ptr<const Subject>& subject)>;

/// Whether a look has still to be chosen for the scene.
bool asks_for_look(const Scene& scene);

/// Reads and converts a volume in the look that the scene asks for. If there are samples of a
/// sequence, they choose all that the scene leaves open. Lights of a look become the world's, so
/// that orbiting keeps them. Takes the fields of `previous`, which may be null, if the scene reads
/// the same ones. Throws Error(input), Error(usage), Error(memory), and what `progress`
/// throws.
std::shared_ptr<Volume> prepare_volume(const Scene& scene, const std::vector<std::string>& samples,
                                       int generation,
                                       const std::shared_ptr<const Volume>& previous,
                                       const StageProgress& progress,
                                       const SubjectKnown& subject_known);

/// The scene with the volume's own medium: what can be drawn of it while another one is prepared.
Scene with_medium_of(const Volume& volume, const Scene& scene);

/// A stage of work, and how much of it is done; 0: not known.
using WorkStage = std::pair<std::string, double>;

/// A thread that works for the window. Its mutex guards what both know.
class Worker {
 public:
  /// The work that takes longer than a picture; nullopt: there is none.
  std::optional<WorkStage> progress() const {
    const std::lock_guard lock(mutex_);
    return progress_;
  }

 protected:
  /// The thread calls `on_news`.
  explicit Worker(std::function<void()> on_news) : on_news_(std::move(on_news)) {}

  void start(std::function<void(std::stop_token)> run) { thread_ = std::jthread(std::move(run)); }
  /// Ends the thread; `change` ends what it works on.
  void stop(const std::function<void()>& change) {
    thread_.request_stop();
    post(change);
    thread_.join();
  }
  /// Changes what the thread is to do, and wakes it.
  void post(const std::function<void()>& change) {
    {
      const std::lock_guard lock(mutex_);
      change();
    }
    changed_.notify_all();
  }
  /// Changes what the window is to know, and has it ask.
  void tell(const std::function<void()>& change) {
    {
      const std::lock_guard lock(mutex_);
      change();
    }
    on_news_();
  }

  std::function<void()> on_news_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<WorkStage> progress_;

 private:
  std::jthread thread_;
};

/// The volume that the window shows, and the thread that prepares the next one. A newer wish
/// replaces an older one. A volume that cannot be loaded leaves the old one.
class CurrentVolume : public Worker {
 public:
  /// What the thread has done for the newest wish since it was last asked.
  struct News {
    std::shared_ptr<const Subject> subject;  ///< of the volume in preparation; null: nothing new
    std::shared_ptr<Volume> volume;          ///< that get() is now; null: none yet
    std::exception_ptr error;                ///< why the wish was refused
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
  News take_news();
  /// The window cannot show the volume that has arrived.
  void refuse() { refused_key_ = volume_->key; }

  bool loading() const { return awaited_key_.has_value(); }
  /// What the first volume shows, while it is loading.
  const std::shared_ptr<const Subject>& first_subject() const { return first_subject_; }

 private:
  struct Wish {
    Scene scene;
    std::vector<std::string> samples;  ///< of its sequence, see prepare_volume
    int generation = 0;
    std::string key;
    bool wanted = false;       ///< by the window now; false: likely to be the next
    std::uint64_t number = 0;  ///< it is outdated once `wishes_` differs
  };
  void run(const std::stop_token& stop);
  void prepare(const Wish& wish);

  // the window's
  std::shared_ptr<Volume> volume_;
  int generation_ = 0;                      ///< of reloads
  std::optional<std::string> awaited_key_;  ///< of the volume in preparation
  std::string refused_key_;                 ///< of the wish that was refused
  std::shared_ptr<const Subject> first_subject_;

  // guarded
  std::optional<Wish> wish_, idle_wish_;
  std::uint64_t wishes_ = 0;  ///< counts them, and the end of one
  News news_;
  std::shared_ptr<const Volume> last_;  ///< the thread's own
  std::shared_ptr<Volume> prefetched_;
};

/// The look of what the window shows, and what it set.
class LookChoice {
 public:
  /// Starts with the scene that the program was started with: its look, or `auto` if it leaves its
  /// look open.
  explicit LookChoice(const Scene& start);

  /// Has the scene ask for a look (`auto`, `smoke`, a name or path of the user's own), without what
  /// the last look has set; the camera stays unless `camera_too`. What the user has changed since
  /// then stays.
  void ask(const std::string& name, Scene& scene, bool camera_too = false);
  const std::string& start() const { return start_; }
  const std::string& name() const { return name_; }
  /// Takes what a volume's look has chosen over to the scene that asked for it, except what the
  /// user has changed meanwhile. Returns what to tell the user; empty: nothing.
  std::string take(const Volume& volume, Scene& scene);
  /// Has the scene name what `auto` chose for the volume, so that it counts for other frames too.
  void hold(const Volume& volume, Scene& scene);

  /// `smoke`, `auto: smoke`
  std::string text() const;

 private:
  std::string start_, name_;      ///< the program's, and the one that was asked for last
  std::string chosen_;            ///< by `auto`
  std::vector<std::string> set_;  ///< parameters that were chosen
  Scene set_scene_;               ///< with their values
};

}  // namespace psivox::view
