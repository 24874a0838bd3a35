#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gl/gl_renderer.h"
#include "psivox/draw.h"
#include "psivox/open.h"
#include "psivox/scene.h"
#include "view/volume.h"

namespace psivox::view {

struct ViewerOptions {
  double frame_budget_ms = 33;
  bool watch = false;  ///< read the file again when it changes
  bool egl = false;    ///< the window's context by EGL
  bool debug = false;  ///< KHR_debug in every context
  bool quiet = false;
  /// To open, in place of the scene's input: several files of a sequence.
  std::vector<std::string> inputs = {};
  bool count_objects = false;  ///< for PictureState::objects, which tests read
  /// Tells what a look has chosen; called unless `quiet`.
  std::function<void(const LookedScene&)> tell_look = {};
  /// Runs `psivox render` with these arguments, and throws its errors.
  std::function<void(const std::vector<std::string>&)> render;
};

/// The layer of a render that the window shows.
enum class ShownLayer { picture, steps, depth, error };

/// Their names, as --aov takes them.
inline constexpr const char* shown_layers[] = {"picture", "steps", "depth", "error"};

void ask_for(ShownLayer layer, Wish& wish);

/// Writes the layer into R G B A of the pictures as colours of viridis. Returns the values at the
/// two ends, which all pictures share. A is 0 where a ray has no depth. A picture without the layer
/// does not change.
glm::dvec2 show_layer(ShownLayer layer, std::span<Image> images);

/// The right side that a comparison starts with: twice the step.
Scene coarser(const Scene& scene);

/// The right side of a comparison: the method of `other`, except what would need another volume,
/// and the rest of `scene`.
Scene with_method_of(const Scene& other, Scene scene);

/// How much cheaper a preview is than the exact picture.
struct Rung {
  double divisor = 1;  ///< of width and height
  double step = 1;     ///< uniform step [voxels], if the scene's method has a step
  bool operator==(const Rung&) const = default;
};

/// Chooses the rung whose pictures take about as long as the budget allows, from the times of the
/// last ones.
class Pace {
 public:
  explicit Pace(double budget_ms) : budget_ms_(budget_ms) {}

  Rung rung() const;
  /// A picture of that rung took so long [ms].
  void took(const Rung& rung, double ms);
  /// The volume or scene changed: known costs are worth little, but the rung stays.
  void forget() { known_ = false; }

 private:
  double budget_ms_;
  double cost_ms_ = 0;  ///< of the full picture, estimated from the last ones
  bool known_ = false;
  int index_ = 5;
};

/// The scene as a rung draws it: a lower resolution, and a uniform step if mode and rule allow one.
/// A surface is found in cells, and a rule that applies the transfer function has tables for its
/// own lengths.
Scene preview_scene(const Scene& scene, const Rung& rung);

/// What the window wants to see: one scene, or two for a comparison, of one volume.
struct PictureWish {
  std::uint64_t number = 0;
  std::shared_ptr<Volume> volume;
  std::vector<Scene> scenes;
  ShownLayer layer = ShownLayer::picture;
};

/// A part of an exact picture, or all of a preview, which is smaller than the window.
struct PicturePart {
  std::uint64_t number = 0;  ///< of its wish
  std::size_t side = 0;      ///< index of its scene
  Image image;
  glm::ivec2 origin{0};  ///< of `image` in the picture
  glm::ivec2 picture_size{0};
};

/// Progress of the pictures that the window asked for. Its wishes are numbered from 1.
struct PictureState {
  std::uint64_t wished = 0;   ///< the newest wish; only the window knows
  std::uint64_t shown = 0;    ///< the wish of the newest preview
  std::uint64_t begun = 0;    ///< the wish of the newest part of an exact picture
  std::uint64_t refined = 0;  ///< the wish whose exact pictures are complete
  double refine_ms = 0, preview_ms = 0;
  Rung rung;  ///< of the last preview
  /// Error of the left exact picture, if its march was planned or the window shows the error.
  std::optional<double> estimated_rms;
  glm::dvec2 layer_range{0};   ///< values at the ends of a layer's colours
  std::string renderer;        ///< once known
  gl::ObjectCounts objects{};  ///< of its context with the exact picture, if they are counted

  bool complete() const { return refined && refined == wished; }
};

/// What a pixel shows.
struct Probed {
  glm::dvec3 point{0};  ///< [world]
  double value = 0;     ///< of the density's file
};

/// What the thread has made since it was last asked.
struct PictureNews {
  std::vector<PicturePart> previews;            ///< the last of each side
  std::vector<PicturePart> parts;               ///< of one wish
  std::optional<glm::dvec3> picked;             ///< point under the pointer; see pick()
  std::optional<std::optional<Probed>> probed;  ///< what is there, if anything; see probe()
  std::vector<std::string> errors;
  std::exception_ptr fatal;  ///< why nothing can be drawn on this machine
  PictureState state;        ///< whether it is new or not
};

/// Draws in a thread of its own, by the renderer of `psivox render` in a context of its own, so
/// that the window answers whatever the march, its compiler or an upload take, and so that the
/// exact picture is the command's. While wishes change it draws previews at its pace, and
/// when the window says that it is at rest, it refines.
class PictureMaker : public Worker {
 public:
  /// `device` as --device takes it. The thread calls `on_news`.
  PictureMaker(const ViewerOptions& options, int device, std::function<void()> on_news);
  ~PictureMaker();

  /// Replaces the last wish.
  void wish(PictureWish wish);
  /// Nothing moves any more: that wish, if it is the last one, may be refined. Only the window
  /// knows: where its own drawing is slow, its wishes come late while the camera moves.
  void rest(std::uint64_t number);
  /// Finds the point where the ray through a pixel (its centre at +0.5) meets what it shows.
  void pick(const glm::dvec2& pixel) { ask(pixel, false); }
  /// Finds the value there.
  void probe(const glm::dvec2& pixel) { ask(pixel, true); }
  /// Builds the shaders anew from their folder.
  void reload_shaders();
  PictureNews news();

 private:
  void run(const std::stop_token& stop);
  void serve(const std::stop_token& stop);
  void make(const PictureWish& wish, const std::stop_token& stop);
  /// Opens the GPU; has the volume lighted, and uploaded, for a scene of it.
  void bring_up(const std::shared_ptr<Volume>& wished, const Scene& scene);
  void draw_previews(const PictureWish& wish);
  void ask(const glm::dvec2& pixel, bool for_value);
  void find_picked(const PictureWish& wish, const glm::dvec2& pixel, bool for_value);
  void renew_renderer();
  void stage(const std::string& name, double fraction);
  void check_current(std::uint64_t number) const;

  void refine(const PictureWish& wish);
  /// Draws one side of a comparison. The parts of a picture go to the window; the colours of a
  /// layer depend on both sides.
  Image refine_side(const PictureWish& wish, std::size_t side);
  void add_part(const PictureWish& wish, std::size_t side, const DoneTile& tile);

  /// Ends the making of a picture that nobody wants any more.
  struct Outdated {};

  ViewerOptions options_;
  ContextOptions context_;
  // guarded
  std::optional<PictureWish> wish_;
  std::optional<std::pair<glm::dvec2, bool>> pick_;  ///< true: for its value
  std::uint64_t resting_ = 0;                        ///< the wish of the last rest()
  bool reload_ = false;
  std::atomic<std::uint64_t> newest_{0};
  std::atomic<bool> interrupted_{false};  ///< a pick or a reload does not wait for a refinement
  PictureNews news_;
  ShownLayer layer_ = ShownLayer::picture;  ///< of the last wish

  // the thread's own
  std::shared_ptr<Marcher> gpu_;
  std::shared_ptr<Volume> shown_;  ///< which the GPU has drawn
  Pace pace_;
};

}  // namespace psivox::view
