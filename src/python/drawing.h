#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/page.h"
#include "psivox/parameters.h"
#include "psivox/picture_file.h"
#include "psivox/vdb.h"

namespace psivox::python {

using MarcherKey = std::pair<RendererKind, int>;  ///< and its device

/// A marcher while somebody draws with it. Others may take it afterwards: opening one takes longer
/// than drawing a small picture.
class Lease {
 public:
  /// The marcher that a scene asks for.
  explicit Lease(const Scene& scene);
  ~Lease();
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;

  bool fits(const Scene& scene) const { return key_ == MarcherKey(scene.renderer, scene.device); }
  Marcher& marcher() { return *marcher_; }
  bool large = false;  ///< what the marcher holds takes so much memory that it is closed

 private:
  MarcherKey key_;
  std::shared_ptr<Marcher> marcher_;
};

/// Closes the marchers that nobody draws with.
void close_marchers();

/// Throws Error(failure) in a process that was forked from one that has drawn: neither threads nor
/// OpenGL survive a fork.
void check_process();

/// A scene as a call gives it: keywords over a camera's file over another scene.
struct SceneWords {
  std::string base;       ///< JSON; empty: the defaults
  std::string base_file;  ///< .json, or a picture that psivox wrote; empty: none
  std::string camera;     ///< FILE[:NAME]; empty: none
  std::vector<std::pair<std::string, std::string>> settings;  ///< in the command line's syntax

  bool give(const std::string& name) const;
};

/// The scene for a file. Throws Error(usage), Error(input).
Scene scene_of(const SceneWords& words, const VolumeFile& file, Scene scene = {});

/// What one picture is to have beside its scene.
struct PictureWords {
  std::vector<std::string> layers;
  int check_error = 0;  ///< pixels to compare with the reference
  std::optional<PageOptions> page{};
};

/// A picture and what drew it.
struct Picture {
  Image image;                                ///< composited with a background that the caller gave
  Scene scene;                                ///< complete, but for the next two
  std::optional<Background> look_background;  ///< of files that show one
  std::optional<double> auto_exposure;        ///< where the scene leaves it to the picture
  Legend legend;
  std::vector<std::string> layers, notices;
  std::string renderer;
  std::optional<MarchPlan> plan;
  std::optional<CheckedError> checked;
  std::string page;  ///< if that was wanted
};

/// Writes as the command line does; returns notices.
std::vector<std::string> write(const Picture& picture, const std::string& path,
                               const WriteOptions& format);

/// A volume in a look that is chosen once, and what its pictures share. Any thread may draw.
class Drawing {
 public:
  Drawing(std::shared_ptr<const VolumeFile> file, const SceneWords& words);
  ~Drawing() { close(); }

  /// The scene with these words over the drawing's own. Where the medium depends on them it is made
  /// anew, else it uses the atlas, light and context of the picture before.
  Picture draw(const SceneWords& words, const PictureWords& wanted, const Progress& progress);

  /// Lets others draw with its context, until the next picture.
  void close();

 private:
  void prepare(const Scene& given, const Progress& progress);
  /// Whether the session has the medium of a scene.
  bool is_prepared(const Scene& given) const;
  /// `scene`, of the session's medium, with the camera, picture and accuracy that `given` says or
  /// leaves to the look.
  Scene in_look(const Scene& given, Scene scene) const;
  Picture finish(Drawn drawn, const Wish& wish, const PictureWords& wanted);
  /// Throws Error(usage) in a call from the `progress` of a picture, which would wait for itself.
  void check_not_drawing() const;

  std::mutex mutex_;
  std::atomic<std::thread::id> drawing_{};  ///< the thread that draws
  std::shared_ptr<const VolumeFile> file_;
  Scene given_;              ///< of the constructor
  bool gives_background_;    ///< so that a look's is not wanted
  Scene prepared_, looked_;  ///< of the look: the scene that it was chosen for, and in it
  std::optional<Background> look_background_;
  Scene own_;  ///< of the session, in the look
  std::optional<Session> session_;
  std::vector<std::string> color_notices_, notices_;
  std::optional<Lease> lease_;
};

/// The view of a study, in the look of a picture.
View study_view(const VolumeFile& file, const SceneWords& words);

}  // namespace psivox::python
