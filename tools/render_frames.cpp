#include <cstdio>
#include <filesystem>
#include <future>
#include <iostream>
#include <nlohmann/json.hpp>

#include "base/input_file.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "base/text_file.h"
#include "notices.h"
#include "psivox/draw.h"
#include "psivox/picture_file.h"
#include "psivox/sequence.h"
#include "render_call.h"
#include "scene/camera_file.h"

namespace psivox {
namespace {

struct ReadFrame {
  std::shared_ptr<Session> session;
  Scene scene;         ///< to draw, complete
  double read_ms = 0;  ///< reading and converting
};

/// Knows the scene of each frame, and reads frames. Only one thread may use it at a time.
class FrameMaker {
 public:
  FrameMaker(const RenderCall& call, const Scene& scene, const FrameList& list,
             const CameraPath* path)
      : film_(file_of_frame(list.frames.front().input)),
        sequence_(chosen_for(list, scene, shows_background(call) || !call.movie.empty(),
                             call.keep_going || list.others_serve)),
        call_(call),
        path_(path),
        first_(list.first),
        film_background_(sequence_.scene.background) {
    if (!shows_background(call)) sequence_.scene.background = scene.background;
    if (path) check_path(list);
    if (!call.turntable || scene.camera_position) return;
    // the camera as the scene sets it, in the look that was chosen
    Scene open = scene;
    open.up_axis = sequence_.scene.up_axis;
    const Scene framed = framed_for_turn(open, *sequence_.subject);
    keep_camera(sequence_.scene, make_camera(framed, *sequence_.subject));
  }

  const SequenceScene& sequence() const { return sequence_; }

  /// The look's or the scene's: of the film, and of pictures that are not to be composited.
  const std::optional<Background>& film_background() const { return film_background_; }

  /// The frame's scene as its picture's metadata has it, without reading voxels; unset if the
  /// camera follows what they show. Throws Error(input).
  std::optional<Scene> scene_of(const Frame& frame) const {
    if (call_.follow) return {};
    return moved(frame_scene(sequence_, VolumeFile(frame.input), frame.input), frame.number);
  }

  /// Reads a frame; the session of the frame before if that has the same file. `alone`: no other
  /// frame has it. Throws Error(input), Error(memory).
  ReadFrame read(const Frame& frame, bool alone = false) {
    const Stopwatch watch;
    if (last_input_ != frame.input) {
      last_session_.reset();
      View view = open_frame(sequence_, VolumeFile(frame.input), frame.input).view;
      if (call_.follow) view = followed(std::move(view));
      last_scene_ = view.scene;
      last_session_ = std::make_shared<Session>(std::move(view), alone);
      // a limit is for one volume: no other one is converted beside it
      if (last_scene_.memory_limit == 0 && last_scene_.renderer != RendererKind::reference)
        last_session_->convert();
      last_input_ = frame.input;
    }
    return {last_session_, moved(last_scene_, frame.number), watch.ms()};
  }

 private:
  /// Throws Error(usage), which names the frame, if the path has no camera there.
  void check_path(const FrameList& list) const {
    for (const Frame& frame : list.frames) try {
        make_camera(path_->at(sequence_.scene, double(frame.number)), *sequence_.subject);
      } catch (const Error& error) {
        throw Error(error.code(), "--camera-path " + in_quotes(call_.camera_path) + ", frame " +
                                      std::to_string(frame.number) + ": " + error.what());
      }
  }

  Scene moved(Scene scene, FrameNumber frame) const {
    if (const auto depths = FramePattern::of_placeholder(scene.holdout))
      scene.holdout = depths->path(frame);
    if (path_) return path_->at(scene, double(frame));
    if (call_.turntable) return turned(scene, 360.0 * double(frame - first_) / *call_.turntable);
    return scene;
  }

  std::shared_ptr<const VolumeFile> film_;  ///< see file_of_frame
  SequenceScene sequence_;
  const RenderCall& call_;
  const CameraPath* path_;
  FrameNumber first_;
  std::optional<Background> film_background_;
  std::string last_input_;
  std::shared_ptr<Session> last_session_;
  Scene last_scene_;
};

/// Whether the frame's picture is there, whole, of that scene and format, and not older than what
/// it was drawn from.
bool stands(const RenderCall& call, FrameMaker& maker, const Frame& frame) {
  namespace fs = std::filesystem;
  try {
    const fs::file_time_type drawn = fs::last_write_time(frame.output);
    std::map<std::string, std::string> found;
    {
      const EarlierOutput standing;
      found = metadata_of_whole(frame.output);
    }
    const std::optional<Scene> scene = maker.scene_of(frame);
    const Scene wanted = scene ? *scene : maker.read(frame).scene;
    for (const std::string& file : files_of(wanted))
      if (drawn < fs::last_write_time(frame_of_file(file).file)) return false;
    std::map<std::string, std::string> metadata =
        picture_metadata({frame.output, call.format, call.layers}, wanted);
    for (const char* name : {"psivox:bits", "psivox:half", "psivox:layers"})
      metadata.try_emplace(name);  // where they are the default
    for (const auto& [name, value] : metadata)
      if (name != "psivox:folder" && found[name] != value) return false;
    return true;
  } catch (const std::runtime_error&) {
    return false;  // drawing it will say why
  }
}

class FrameLoop {
 public:
  FrameLoop(const RenderCall& call, FrameMaker& maker, std::future<std::shared_ptr<Marcher>> opened)
      : call_(call), maker_(maker), opened_(std::move(opened)), bar_(call.quiet) {
    if (!call.movie.empty() && can_make_movies()) movie_.emplace(call.movie, call.frame_rate);
  }
  /// Waits for what other threads do.
  ~FrameLoop() {
    if (next_.valid()) next_.wait();
    if (written_.valid()) written_.wait();
    notices_.say(bar_);
  }

  void run(const std::vector<Frame>& frames) {
    std::vector<std::size_t> wanted;
    for (std::size_t i = 0; i < frames.size(); ++i)
      if (!call_.resume || !stands(call_, maker_, frames[i])) wanted.push_back(i);
    standing_ = frames.size() - wanted.size();
    if (standing_)
      say(formatted("%zu frame%s already", standing_, standing_ == 1 ? " stands" : "s stand"));
    const auto read_ahead = [&](std::size_t k) {
      if (k == wanted.size()) return;
      const Frame& frame = frames[wanted[k]];
      const auto has_input = [&](std::size_t n) {
        return n < wanted.size() && frames[wanted[n]].input == frame.input;
      };
      const bool alone = !has_input(k + 1) && (k == 0 || !has_input(k - 1));
      next_ = std::async(std::launch::async,
                         [this, &frame, alone] { return maker_.read(frame, alone); });
    };
    read_ahead(0);
    for (std::size_t i = 0, k = 0; i < frames.size(); ++i) {
      if (k == wanted.size() || wanted[k] != i) {
        if (movie_) add_standing(frames[i]);
        continue;
      }
      done_ = double(k) / double(wanted.size());
      part_ = 1 / double(wanted.size());
      ++k;
      ReadFrame read;
      try {
        const Stopwatch waiting;
        read = next_.get();
        waited_ms_ += waiting.ms();
      } catch (const Error& error) {
        read_ahead(k);
        report_bad(frames[i], error);
        continue;
      }
      read_ahead(k);
      write(draw(frames[i], read));
    }
    take_written();
  }

  /// Ends the film, writes the statistics, and throws Error(input) if frames could not be read, or
  /// Error(output) if there is no ffmpeg for the film.
  void finish() {
    if (movie_) movie_->finish();
    notices_.say(bar_);
    const double total_ms = watch_.ms();
    if (!call_.stats.empty()) {
      const nlohmann::ordered_json all = {
          {"frames", reports_},
          {"standing", standing_},
          {"bad", bad_},
          {"times_ms", {{"total", total_ms}, {"waited", waited_ms_}}}};
      write_text(call_.stats,
                 all.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    }
    if (call_.verbose)
      print(stderr, formatted("frames    %d in %.1f s, of which %.1f s waiting for reading and "
                              "writing\n",
                              drawn_, 1e-3 * total_ms, 1e-3 * waited_ms_));
    if (movie_ && !bad_.empty())
      say(formatted("the film is %zu frame%s shorter", bad_.size(), bad_.size() == 1 ? "" : "s"));
    if (!bad_.empty())
      throw Error(ExitCode::input,
                  std::to_string(bad_.size()) + " of " +
                      std::to_string(bad_.size() + std::size_t(drawn_) + standing_) +
                      " frames could not be read: " + frames_text(bad_));
    if (!movie_ && !call_.movie.empty())
      throw Error(
          ExitCode::output,
          "the film is not made, because ffmpeg is not installed; with it, the same command" +
              std::string(holds_scene(call_.output) ? " and --resume" : "") + " makes it");
  }

 private:
  /// A frame that was drawn, for the thread that writes it.
  struct DrawnFrame {
    Frame frame;
    RenderReport report;
  };

  std::shared_ptr<DrawnFrame> draw(const Frame& frame, const ReadFrame& read) {
    if (!marcher_) marcher_ = opened_.get();
    Wish wish = wish_of(call_);
    wish.scene = read.scene;
    if (progress_)
      wish.progress = over_stages([this](double done) { progress_(done_ + part_ * done); });
    const Stopwatch drawing;
    auto drawn = std::make_shared<DrawnFrame>();
    drawn->frame = frame;
    drawn->report.input = frame.input;
    drawn->report.output = frame.output;
    drawn->report.read_ms = read.read_ms;
    Drawn& picture = drawn->report.drawn = read.session->draw(*marcher_, wish);
    picture.view.scene = read.scene;  // as it was asked for
    for (const std::string& notice : notices_of(picture.view)) say(notice, frame.number);
    for (const std::string& notice : picture.notices) say(notice, frame.number);
    say(blank_reason(picture.view, picture.image), frame.number);
    drawn->report.total_ms = drawing.ms();
    ++drawn_;
    return drawn;
  }

  void write(std::shared_ptr<DrawnFrame> drawn) {
    take_written();
    written_ = std::async(std::launch::async, [this, drawn = std::move(drawn)] {
      if (!drawn->frame.output.empty()) write_picture(call_, drawn->report);
      if (movie_) add_to_movie(*drawn);
      drawn->report.drawn.image = {};
      return drawn;
    });
  }

  /// Adds a frame that was written, unless the film alone has it.
  void add_to_movie(DrawnFrame& drawn) {
    Drawn& picture = drawn.report.drawn;
    Scene scene = picture.view.scene;
    scene.background = maker_.film_background();
    if (drawn.frame.output.empty() || !holds_codes(drawn.frame.output, call_.format))
      for (const std::string& notice :
           complete_picture(picture.image, scene, legend_of(picture.view), /*codes=*/true))
        drawn.report.written.notices.push_back(notice);
    movie_->add(picture.image, display_of(scene));
  }

  void take_written() {
    if (!written_.valid()) return;
    const Stopwatch waiting;
    const std::shared_ptr<DrawnFrame> written = written_.get();
    waited_ms_ += waiting.ms();
    for (const std::string& notice : written->report.written.notices)
      say(notice, written->frame.number);
    const RenderReport& report = written->report;
    if (!call_.stats.empty()) {
      nlohmann::ordered_json row = report.as_json();
      row["frame"] = written->frame.number;
      reports_.push_back(std::move(row));
    }
    if (call_.verbose) {
      bar_.clear();
      print(stderr, formatted("frame %lld\n", static_cast<long long>(written->frame.number)) +
                        report.table());
    }
  }

  void add_standing(const Frame& frame) {
    take_written();
    const Scene& scene = maker_.sequence().scene;
    const bool coded = holds_codes(frame.output, call_.format);
    Image image = read_image(frame.output);
    if (!coded && maker_.film_background())
      add_background(image, maker_.film_background()->color, {});
    movie_->add(image, coded ? Display{} : display_of(scene));
  }

  /// Throws the error on, unless --keep-going goes on after it.
  void report_bad(const Frame& frame, const Error& error) {
    if (!call_.keep_going || error.code() != ExitCode::input) throw;
    bad_.push_back(frame.number);
    bar_.say("frame " + std::to_string(frame.number) + ": " + error.what());
  }

  void say(const std::string& notice) {
    if (!call_.quiet) bar_.say(notice);
  }

  /// Keeps what is to be said of a frame for the end.
  void say(const std::string& notice, FrameNumber frame) {
    if (!call_.quiet) notices_.add(notice, frame);
  }

  const RenderCall& call_;
  FrameMaker& maker_;
  std::future<std::shared_ptr<Marcher>> opened_;
  std::shared_ptr<Marcher> marcher_;
  std::future<ReadFrame> next_;
  std::future<std::shared_ptr<DrawnFrame>> written_;
  std::optional<Movie> movie_;
  ProgressBar bar_;
  Progress progress_ = bar_.progress();
  Stopwatch watch_;
  FrameNotices notices_;
  std::vector<FrameNumber> bad_;
  int drawn_ = 0;
  std::size_t standing_ = 0;
  double done_ = 0, part_ = 0;  ///< of the work: before the frame that is drawn, and that frame's
  double waited_ms_ = 0;
  nlohmann::ordered_json reports_ = nlohmann::ordered_json::array();
};

}  // namespace

void render_frames(const RenderCall& call, const Scene& scene, const FrameList& list,
                   const CameraPath* path) {
  if (call.explain || call.check_error)
    usage(std::string(call.explain ? "--explain" : "--check-error") +
          " is for one picture: give one file");
  if (is_standard_output(call.output) && list.frames.size() > 1)
    usage("-o " + call.output + " takes one picture");
  if (call.resume && !call.output.empty() && !holds_scene(call.output))
    usage("--resume reads a picture's scene, which " + in_quotes(call.output) +
          " cannot hold; write .png or .exr");
  if (!call.movie.empty() && !is_movie_name(call.movie))
    usage("--movie " + in_quotes(call.movie) + ": expected .mp4, .mov, .mkv or .avi");
  if (!call.movie.empty() && call.output.empty() && !can_make_movies())
    throw Error(ExitCode::output,
                "--movie needs ffmpeg, which is not installed; -o out.####.png writes pictures");
  std::future<std::shared_ptr<Marcher>> opened;
  const bool draws = !call.output.empty() || !call.movie.empty();
  if (draws) opened = std::async(std::launch::async, [&scene] { return open_marcher(scene); });
  FrameMaker maker(call, scene, list, path);
  check_outputs(call, "");
  if (!call.quiet) print_choice(maker.sequence(), list, call.verbose);
  if (call.print_scene) std::cout << to_json(maker.sequence().scene) << std::flush;
  if (call.print_scene && !call.quiet && (call.turntable || call.follow || path))
    print_notice("the scene has one camera: give what moves it again beside --scene");
  if (!call.camera.empty()) {
    const Scene& chosen = maker.sequence().scene;
    write_camera(call.camera, make_camera(chosen, *maker.sequence().subject),
                 chosen.up_axis == UpAxis::z);
  }
  if (!draws) return;
  remove_abandoned_files(std::filesystem::path(call.output).parent_path());
  FrameLoop loop(call, maker, std::move(opened));
  loop.run(list.frames);
  loop.finish();
}

}  // namespace psivox
