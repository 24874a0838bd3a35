#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "view/files.h"
#include "view/navigation.h"
#include "view/picture_display.h"
#include "view/picture_maker.h"
#include "view/transfer_editor.h"
#include "view/window.h"

namespace psivox::view {

/// Which panels are open, and the text typed into them.
struct Panels {
  bool scene = true, transfer = false, help = false;
  bool color_bar = false, axes = false, box = false, files = false;
  std::string folder;   ///< of the list of files
  bool slices = false;  ///< the scene was a slice when the panels were last drawn
  std::string open_path;
  std::string picture_path = "picture.exr", scene_path = "scene.json";
  std::string picture_size;  ///< WxH of saved pictures; empty: the window's
};

class Viewer;

/// Keys and the pointer: they move the camera and give commands to the viewer.
class Controls {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Controls(Viewer& viewer) : viewer_(viewer) {}

  void key(const Event& event);
  void button(const Event& event);
  void move(const Event& event);
  /// Moves the camera while keys of flight are down. True if it moved.
  bool fly(Clock::time_point now);

  bool dragging() const { return button_ >= 0; }
  bool flying() const { return speed_ != glm::dvec3(0); }

 private:
  /// True if the key is one of flight and nothing else.
  bool steer(const Event& event);
  /// Whether this is the second click of two.
  bool double_click(const glm::dvec2& place);

  Viewer& viewer_;
  int button_ = -1;  ///< that was pressed over the picture; -1: none
  bool dragging_divider_ = false;
  glm::dvec2 pointer_{0};
  Clock::time_point clicked_{};
  glm::dvec2 clicked_at_{0};
  glm::dvec3 speed_{0};  ///< along right, up and forward
  Clock::time_point flown_{};
};

/// Whether a command's key is pressed with Ctrl.
enum class Control { free, held, either };

/// What a key does, or a drag: a row of the help in the window and in docs/preview.md.
struct Command {
  const char* keys;
  const char* what;
  std::vector<int> codes = {};  ///< GLFW's; none: Controls has it itself
  std::function<void(Viewer&, const Event&)> act = {};
  Control control = Control::free;
};

const std::vector<Command>& commands();

/// The preview: a window, what it shows, and the threads that make it.
class Viewer {
 public:
  /// Throws Error(graphics) if there is no display.
  Viewer(const Scene& scene, const ViewerOptions& options);
  ~Viewer();

  /// Waits for events, at most `wait_s`, and draws the window if something happened. False once the
  /// window is closed. Throws what the first load throws, and Error(graphics) if nothing can be
  /// drawn: a window that never shows anything is of no use.
  bool frame(double wait_s);
  void run();

  // Commands of keys, panels and drops.
  /// A file, several, a folder or a pattern; or a scene, in JSON or in a picture.
  void open(const std::vector<std::string>& inputs);
  /// The scene's resolution is ignored: it is the window's.
  void set_scene(const Scene& scene);
  /// Takes back the last change of the scene, but for the camera; none if there is none.
  void undo();
  /// Gives the file a look: `auto`, `smoke`, a name or path of the user's own. The camera stays.
  void choose_look(const std::string& name);
  void compare(Comparison comparison, const std::optional<Scene>& other);
  void show(ShownLayer layer);
  void reload();
  /// Puts the pivot on what the pixel shows.
  void pick(const glm::dvec2& pixel) { maker_.pick(pixel); }
  /// Looks up the value that the pixel shows, once the picture is at rest.
  void probe(const glm::dvec2& pixel);
  const std::optional<Probed>& probed() const { return probed_; }
  void save_picture(const std::string& path);
  std::string copy_command_line();
  /// Saves the camera alone if a file of this name holds a camera.
  void save_scene(const std::string& path);
  /// Draws the panel of the transfer function, which edits the scene.
  void edit_transfer_function();
  /// Writes what the window shows to a .png.
  void photograph(const std::string& path);

  ViewerOptions& options() { return options_; }
  Window& window() { return window_; }
  const Gui& gui() const { return gui_; }
  Navigation& navigation() { return navigation_; }
  Sequence& sequence() { return now_.sequence; }
  const Sequence& sequence() const { return now_.sequence; }
  Panels& panels() { return panels_; }
  DisplaySettings& display() { return settings_; }
  const LookChoice& look() const { return now_.look; }
  const TransferEditor& transfer_editor() const { return editor_; }
  Messages& messages() { return messages_; }
  const Messages& messages() const { return messages_; }
  const PictureState& pictures() const { return pictures_; }

  /// The scene to show, in the window's resolution.
  Scene scene() const;
  const std::string& input() const { return now_.scene.input; }
  /// The right side of a comparison; its method counts.
  const std::optional<Scene>& other() const { return other_; }
  ShownLayer layer() const { return layer_; }
  /// The window's exposure [powers of 2]: the scene's, or what `auto` chose for the last preview.
  double exposure() const { return now_.scene.exposure.value_or(auto_exposure_); }
  const Volume* volume() const { return volume_.get().get(); }
  bool loading() const { return volume_.loading(); }
  const Subject* first_subject() const { return volume_.first_subject().get(); }
  std::optional<WorkStage> loading_stage() const { return volume_.progress(); }
  std::optional<WorkStage> drawing_stage() const { return maker_.progress(); }
  bool saving() const { return saving_.valid(); }
  const std::string& saved_path() const { return saved_path_; }
  /// The exact picture of the scene; unset until it is complete.
  std::optional<Image> exact_picture() const;
  /// The same, or the colours of the layer that is shown. Side 1 is the right one of a comparison.
  std::optional<Image> complete_picture(std::size_t side = 0) const;

 private:
  using Clock = std::chrono::steady_clock;

  /// The files that were opened, and how they are shown.
  struct Opened {
    Scene scene;  ///< navigation_ has its camera once that was moved
    LookChoice look;
    Sequence sequence;
    std::vector<std::string> inputs;
  };

  /// Keeps what the scene was before a change, unless a hand goes on with the last one.
  void remember();
  void open_files(const std::vector<std::string>& inputs);
  void open_scene(const std::string& path);
  /// Shows what was opened by that name.
  void start(Opened next, const std::string& name);
  void handle(const Event& event);
  /// Draws at least so many of the next frames.
  void redraw(int frames);
  void draw(double seconds);
  /// The scene for a saved picture: in its size, and with the transfer function in a file that
  /// stays.
  Scene kept_scene();
  void take_news();
  void take_volume_news();
  void take_look();
  void take_volume(bool first);
  void keep_old_volume(const std::exception_ptr& refusal);
  void take_pictures();
  void take_saved();
  void follow_sequence();
  void update_wishes();
  /// Has the last wish refined once nothing has changed for a moment.
  void notice_rest();
  /// Asks for the pictures of a scene, in the old volume if its own is not at hand.
  void wish_pictures(const Scene& wanted, bool at_hand);

  ViewerOptions options_;
  Window window_;
  Gui gui_;
  PictureDisplay display_;
  CurrentVolume volume_;
  PictureMaker maker_;
  TransferEditor editor_;
  Navigation navigation_;
  Controls controls_{*this};
  Panels panels_;
  Messages messages_;
  FileWatch watch_;
  DisplaySettings settings_;

  Opened now_;
  std::vector<std::pair<Scene, LookChoice>> history_;  ///< of changes, the last one last
  bool changing_ = false;                              ///< a hand is still on what has changed
  std::optional<Opened> fallback_;  ///< before the file or look in preparation was asked for
  std::optional<Scene> other_;      ///< of a comparison
  ShownLayer layer_ = ShownLayer::picture;
  double auto_exposure_ = 0;
  PictureState pictures_;
  std::optional<Probed> probed_;    ///< under the pointer
  std::string posted_;              ///< text of the last wish
  double quiet_s_ = 0;              ///< waited for events since that wish
  std::uint64_t rested_ = 0;        ///< the last wish that may be refined
  bool at_hand_ = false;            ///< the volume is the scene's
  bool camera_due_ = true;          ///< the next volume brings its own camera
  std::exception_ptr first_error_;  ///< after which the window would never show anything
  std::string photograph_;          ///< file for the next frame; empty: none
  std::string saved_path_;
  std::future<void> saving_;  ///< of the picture that is saved; throws why it was not
  Clock::time_point last_frame_ = Clock::now();
  int frames_due_ = 3;  ///< to draw though nothing happens, while panels settle
  bool closed_ = false;
};

/// Draws everything but the picture, and carries out the commands of its widgets.
void draw_panels(Viewer& viewer);
/// The colours of the values, as the window shows them.
void draw_color_bar(const Viewer& viewer);
/// The world's axes and the volume's box with ticks, as in pictures. Throws Error(usage) for a
/// scene without a camera.
void draw_marks(Viewer& viewer);
/// A panel with the volumes of a folder, which clicks on folders change; empty: the working one.
/// True if a file is chosen.
bool browse(std::string& folder, std::string& file, bool& open);

}  // namespace psivox::view
