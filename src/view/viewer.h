#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "view/gui.h"
#include "view/navigation.h"
#include "view/picture_display.h"
#include "view/picture_maker.h"
#include "view/save_job.h"
#include "view/sequence.h"
#include "view/transfer_editor.h"
#include "view/volume_loader.h"
#include "view/window.h"

namespace psivox::view {

struct ViewerOptions {
  double frame_budget_ms = 33;
  bool watch = false;  ///< read the file again when it changes
  bool egl = false;    ///< the window's context by EGL
  bool debug = false;  ///< KHR_debug in every context
  bool quiet = false;
  bool count_objects = false;  ///< for picture_objects()
  /// `psivox render` with these arguments; throws what it throws.
  std::function<void(const std::vector<std::string>&)> render;
};

/// The preview: a window, what it shows, and the threads that make it.
class Viewer {
 public:
  /// Throws Error(graphics) where there is no display.
  Viewer(const Scene& scene, const ViewerOptions& options);
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  /// Waits at most so long [s] for something to happen, and draws the window if something did.
  /// False once it is closed. Throws what the first load throws, and Error(graphics) where nothing
  /// can be drawn: a window that never shows anything is no use.
  bool frame(double wait_s);
  /// Frames until it is closed.
  void run();

  Window& window() { return window_; }
  Navigation& navigation() { return navigation_; }
  const TransferEditor& transfer_editor() const { return editor_; }
  /// The scene that is wished, in the window's resolution.
  Scene scene() const;
  /// The exact picture of what is wished now, or null while it is not complete. `side`: 1 is
  /// the right one of a comparison.
  const Image* exact_picture() const;
  /// What is wished, in full, where it is a layer its colours; null while it is not complete.
  const Image* complete_picture(std::size_t side = 0) const;
  /// Of the wish that the newest picture on the screen is of; and of the newest wish.
  std::uint64_t shown() const { return shown_; }
  std::uint64_t wished() const { return wished_; }
  bool loading() const { return awaited_key_.has_value(); }
  double refine_ms() const { return refine_ms_; }
  const Volume* volume() const { return volume_.get(); }
  const std::string& renderer() const { return renderer_; }
  /// OpenGL objects of the context that draws, when the last exact picture was complete;
  /// with ViewerOptions::count_objects.
  const gl::ObjectCounts& picture_objects() const { return picture_objects_; }
  /// What went wrong last, as the window shows it.
  const std::string& last_error() const { return last_error_; }
  /// How much went wrong so far.
  int problems() const { return problems_; }

  // What keys, buttons and drops do.
  void open(const std::string& path);
  void set_scene(const Scene& scene);
  void compare(Comparison comparison, const std::optional<Scene>& other);
  void reload();
  void save_picture(const std::string& path);
  std::string copy_command_line();
  void save_scene(const std::string& path);
  bool saving() const { return save_.running(); }
  void show(ShownLayer layer);
  /// Writes what the window shows to a .png.
  void photograph(const std::string& path);
  void show_panel(bool transfer_function) { show_transfer_ = transfer_function; }

 private:
  using Clock = std::chrono::steady_clock;

  // viewer.cpp
  void take_news();
  void take_volume(std::shared_ptr<Volume> volume);
  void update_wishes();
  void draw(double seconds);
  void watch_files();
  void error(const std::string& message);
  void say(const std::string& message);
  /// What goes wrong in it is said.
  void attempt(const std::function<void()>& action);
  /// The scene, with its transfer function in a file that stays.
  Scene kept_scene();
  void take_loader_news();
  void take_pictures();
  void step_sequence();

  // viewer_input.cpp
  void handle(const Event& event);
  void handle_button(const Event& event);
  void handle_move(const Event& event);
  void handle_key(const Event& event);
  void fly(Clock::time_point now);

  // viewer_panels.cpp
  void draw_panels();
  void draw_scene_panel();
  void draw_file_section();
  void draw_output_section();
  void draw_display_section();
  /// What the picture is, or what it waits for.
  std::string status() const;
  void draw_status();
  void draw_help();
  void draw_box();
  void draw_timeline();

  ViewerOptions options_;
  Window window_;
  Gui gui_;
  PictureDisplay display_;
  VolumeLoader loader_;
  PictureMaker maker_;
  SaveJob save_;
  TransferEditor editor_;
  Navigation navigation_;
  DisplaySettings look_;
  Sequence sequence_;

  Scene scene_;                 ///< wished; its camera is navigation_'s once that was moved
  std::optional<Scene> other_;  ///< of a comparison: integrator and march of the right side
  int generation_ = 0;          ///< of reloads
  std::optional<std::string> awaited_key_;  ///< of the volume that is being loaded
  std::string refused_key_;                 ///< that could not be loaded
  std::shared_ptr<Volume> volume_;
  bool camera_due_ = true;          ///< the next volume's own camera is to be taken
  std::exception_ptr first_error_;  ///< after which the window would never show anything
  std::string posted_;              ///< text of the last wish
  std::uint64_t wished_ = 0, shown_ = 0, refined_ = 0;
  std::optional<double> estimated_rms_;
  double refine_ms_ = 0, preview_ms_ = 0;
  Rung rung_;
  ShownLayer layer_ = ShownLayer::picture;
  glm::dvec2 layer_range_{0};
  std::optional<std::pair<glm::dvec3, glm::dvec3>> box_;  ///< of what is being loaded
  std::string renderer_, last_error_, message_;
  gl::ObjectCounts picture_objects_;
  int problems_ = 0;
  std::string photograph_;  ///< where the next frame is to be written
  Clock::time_point message_since_{};
  Clock::time_point last_frame_ = Clock::now();
  std::string watched_, watched_stamp_;
  Clock::time_point watched_at_{}, stepped_at_{};
  int frames_due_ = 3;  ///< that are drawn though nothing happens: the panels settle
  bool closed_ = false;
  bool show_panels_ = true, show_transfer_ = false, show_help_ = false;
  std::string picture_size_, picture_path_ = "picture.exr", scene_path_ = "scene.json", open_path_;

  int dragging_ = -1;  ///< button over the picture, -1: none
  bool dragging_divider_ = false;
  glm::dvec2 pointer_{0};
  Clock::time_point clicked_{};
  glm::dvec2 clicked_at_{0};
  glm::dvec3 flying_{0};  ///< along right, up and forward
  Clock::time_point flown_{};
};

}  // namespace psivox::view
