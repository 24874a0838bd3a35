#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "gl/object_counts.h"
#include "psivox/draw.h"
#include "view/shown.h"
#include "view/volume.h"

namespace psivox::view {

/// What the window wants to see: one scene, or two for a comparison, of one volume.
struct PictureWish {
  std::uint64_t number = 0;
  std::shared_ptr<Volume> volume;
  std::vector<Scene> scenes;
  ShownLayer layer = ShownLayer::picture;
};

/// A picture while things move, smaller than the window.
struct PreviewPicture {
  std::uint64_t number = 0;  ///< of its wish
  std::size_t side = 0;      ///< index of its scene
  Image image;
  Rung rung;
  double ms = 0;
};

struct ExactPart {
  std::uint64_t number = 0;
  std::size_t side = 0;
  glm::ivec2 picture_size{0};
  glm::ivec2 origin{0}, size{0};
  std::vector<float> rgba;
};

/// What the thread has made since it was last asked.
struct PictureNews {
  std::vector<PreviewPicture> previews;  ///< the last of each side
  std::vector<ExactPart> parts;          ///< of one wish
  std::optional<std::uint64_t> refined;  ///< the wish whose exact pictures are complete
  double refine_ms = 0;
  /// Error of the left exact picture, if its march was planned or the window shows the error.
  std::optional<double> estimated_rms;
  std::optional<glm::dvec2> layer_range;  ///< values at the ends of a layer's colours
  std::optional<glm::dvec3> picked;       ///< point under the pointer; see pick()
  std::vector<std::string> errors;
  std::exception_ptr fatal;  ///< why nothing can be drawn on this machine
  std::string renderer;      ///< once known
  gl::ObjectCounts objects;  ///< of its context with the exact picture, if they are counted
};

/// Draws in a thread of its own, by the renderer of `psivox render` in a context of its own, so
/// that the window answers whatever the march, its compiler or an upload take, and so that the
/// exact picture is the command's. While wishes change it draws previews at its pace, and
/// when the window says that it is at rest, it refines.
class PictureMaker {
 public:
  struct Options {
    double budget_ms = 33;
    int device = -1;
    bool debug = false;          ///< KHR_debug: messages become errors
    bool count_objects = false;  ///< OpenGL's, with each exact picture
  };

  PictureMaker(const Options& options, std::function<void()> on_news);
  ~PictureMaker();

  /// Replaces the last wish.
  void wish(PictureWish wish);
  /// Nothing moves any more: that wish, if it is the last one, may be refined. Only the window
  /// knows: where its own drawing is slow, its wishes come late while the camera moves.
  void rest(std::uint64_t number);
  /// Finds the point where the ray through a pixel (its centre at +0.5) meets what it shows.
  void pick(const glm::dvec2& pixel);
  /// Builds the shaders anew from their folder.
  void reload_shaders();
  PictureNews news();
  /// The stage of work that takes longer than a picture, and how much of it is done; 0: not known.
  /// nullopt: there is no such work.
  std::optional<std::pair<std::string, double>> progress() const;

 private:
  /// Changes what the thread is to do, and wakes it.
  void post(const std::function<void()>& change);
  void run(const std::stop_token& stop);
  void serve(const std::stop_token& stop);
  void make(const PictureWish& wish, const std::stop_token& stop);
  /// Opens the GPU; has the volume lighted, and uploaded, for a scene of it.
  void bring_up(const std::shared_ptr<Volume>& wished, const Scene& scene);
  void draw_previews(const PictureWish& wish);
  void find_picked(const PictureWish& wish, const glm::dvec2& pixel);
  void renew_renderer();
  void stage(const std::string& name, double fraction);
  void check_current(std::uint64_t number) const;
  /// Adds to the news, and has the window take them.
  void tell(const std::function<void(PictureNews&)>& change);

  void refine(const PictureWish& wish);
  void refine_side(const PictureWish& wish, std::size_t side);
  void refine_layers(const PictureWish& wish);
  /// The wish to the session for one side of a comparison. The window shows its progress.
  Wish exact_wish(const PictureWish& wish, std::size_t side);
  Drawn draw(const PictureWish& wish, std::size_t side, const Wish& exact);
  void add_part(const PictureWish& wish, std::size_t side, const DoneTile& tile);

  /// Ends the making of a picture that nobody wants any more.
  struct Outdated {};

  Options options_;
  std::function<void()> on_news_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<PictureWish> wish_;
  std::optional<glm::dvec2> pick_;
  std::uint64_t resting_ = 0;  ///< the wish of the last rest()
  bool reload_ = false;
  std::atomic<std::uint64_t> newest_{0};
  std::atomic<bool> interrupted_{false};  ///< a pick or a reload does not wait for a refinement
  PictureNews news_;
  std::optional<std::pair<std::string, double>> progress_;

  // the thread's own
  std::shared_ptr<Marcher> gpu_;
  std::shared_ptr<Volume> shown_;  ///< which the GPU has drawn
  Pace pace_;
  std::jthread thread_;
};

/// Progress of the pictures that the window asked for. Its wishes are numbered from 1.
struct PictureState {
  std::uint64_t wished = 0;   ///< the newest wish
  std::uint64_t shown = 0;    ///< the wish of the newest picture on the screen
  std::uint64_t begun = 0;    ///< the wish of the newest part of an exact picture
  std::uint64_t refined = 0;  ///< the wish whose exact pictures are complete
  double refine_ms = 0, preview_ms = 0;
  Rung rung;                            ///< of the last preview
  std::optional<double> estimated_rms;  ///< of the exact picture
  glm::dvec2 layer_range{0};            ///< values at the ends of a layer's colours
  std::string renderer;
  gl::ObjectCounts objects;  ///< of the context that draws, if they are counted

  bool complete() const { return refined && refined == wished; }

  void take(const PictureNews& news) {
    for (const PreviewPicture& picture : news.previews) {
      shown = std::max(shown, picture.number);
      rung = picture.rung;
      preview_ms = picture.ms;
    }
    for (const ExactPart& part : news.parts) begun = std::max(begun, part.number);
    if (news.estimated_rms) estimated_rms = news.estimated_rms;
    if (news.refined) {
      refined = *news.refined;
      refine_ms = news.refine_ms;
    }
    layer_range = news.layer_range.value_or(layer_range);
    if (!news.renderer.empty()) renderer = news.renderer;
    objects = news.objects;
  }
};

}  // namespace psivox::view
