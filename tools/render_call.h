#pragma once

#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/text_file.h"
#include "command_line.h"
#include "psivox/draw.h"
#include "psivox/image.h"
#include "psivox/page.h"
#include "psivox/picture_file.h"
#include "psivox/sequence.h"
#include "sequence/camera_motion.h"

namespace psivox {

/// What the command line of `psivox render` asks for.
struct RenderCall {
  SceneOptions scene;
  FrameOptions sequence;
  std::string output, stats, camera;
  std::vector<std::string> layers;  ///< named by --aov
  std::optional<int> check_error;   ///< pixels
  std::optional<int> thumbnail;     ///< side [pixels]
  std::string thumbnail_name;       ///< may lack an extension, which `output` then has
  WriteOptions format;
  PageOptions page;  ///< where the output is one
  bool print_scene = false, explain = false, verbose = false, quiet = false, list_devices = false;

  // of a sequence
  std::string camera_path, movie;
  std::optional<int> turntable;  ///< pictures of a whole turn
  double frame_rate = 24;        ///< [frames/s]
  bool follow = false, resume = false, keep_going = false;
};

/// Returns false if it printed the help that was asked for. Throws Error(usage).
bool parse(RenderCall& call, Arguments arguments);

/// Without --aov, takes the layers of --scene's picture that the output can have.
void take_layers(RenderCall& call, const Scene& scene);

/// Makes every check that needs no work. Throws Error(usage), Error(memory), Error(output).
void check(const RenderCall& call, const Scene& scene);

/// The picture that the call asks for, without progress.
Wish wish_of(const RenderCall& call);

/// A file that an option writes. An empty path is none.
struct WrittenFile {
  const char* option;
  std::string path;
};

/// Throws Error(usage) if one of the files is an input of the call (see InputProtection), by
/// whatever name or link, or written by two options. Empty names and `-` are no files.
void check_overwriting(std::span<const WrittenFile> written);

/// The same for all that the call writes beside a picture: once by the names of its inputs, and
/// again when these were read and have told what lies beside them.
void check_outputs(const RenderCall& call, const std::string& picture);

struct Frame {
  FrameNumber number = 0;
  std::string input, output;  ///< `output` is empty if only a film is written
};

struct FrameList {
  std::vector<Frame> frames;         ///< ascending
  FrameNumber first = 1;             ///< number of the sequence's first frame, drawn or not
  std::vector<std::string> files;    ///< of the sequence, drawn or not
  std::vector<std::string> samples;  ///< files from which `auto` chooses
  std::vector<std::string> notices;  ///< one line each
  /// Whether a sample that cannot be read is replaced: nobody named it, nor a frame of it.
  bool others_serve = false;
  Headers headers = Headers::seen;
};

/// The frames of files. Throws Error(usage), and Error(input) for frames that are missing.
FrameList list_files(const FrameOptions& options, const SequenceFiles& files);

/// The frames that a call asks for; unset: it asks for one picture. `path`: the camera's, or null.
/// Throws Error(usage), and Error(input) for frames that are missing.
std::optional<FrameList> list_frames(const RenderCall& call, const Scene& scene,
                                     const CameraPath* path);

/// What `auto` chooses for the frames. `others_serve`: see FrameList.
SequenceScene chosen_for(const FrameList& list, const Scene& scene, bool background,
                         bool others_serve);

/// Prints to stderr the look that was chosen for all frames, or what it sets, as options.
void print_choice(const SequenceScene& sequence, const FrameList& list, bool to_copy = true);

/// Draws the frames of a sequence. While one is drawn, the next is read and converted, and the one
/// before is written, so that at most two volumes and two pictures are in memory. Throws
/// Error(input) at the end if --keep-going went on after frames that could not be read.
void render_frames(const RenderCall& call, const Scene& scene, const FrameList& list,
                   const CameraPath* path);

/// Time since the process started, which includes loading its libraries [ms].
double process_ms();

/// What one `psivox render` did, for --stats and -v.
struct RenderReport {
  std::string input, output;
  Drawn drawn;
  double startup_ms = 0;  ///< until the command began: loading of libraries
  double read_ms = 0, total_ms = 0;
  std::optional<CheckedError> checked;  ///< from --check-error
  WrittenPicture written;

  nlohmann::ordered_json as_json() const;
  std::string json() const;
  std::string table() const;  ///< lines to be read by people
};

/// Whether a look's background is wanted: not where a picture may be composited as it is, nor where
/// --background is given, if only as `none`.
bool shows_background(const RenderCall& call);

/// Writes the report's picture with its scene, composited with the background and with the color
/// bar that the scene asks for, to the file that it names. Throws Error(output).
void write_picture(const RenderCall& call, RenderReport& report);

/// Writes the picture of `psivox render` as write_picture does, or its page, and prints what there
/// is to say.
void put_out(const RenderCall& call, Session& session, RenderReport& report);

/// A film that ffmpeg writes from pictures. It appears under its name when it is complete.
class Movie {
 public:
  /// `path` must be a film's name. Throws Error(output) if no file can be made there.
  Movie(const std::string& path, double frame_rate);
  ~Movie();

  /// Appends a picture, over black. All have one size. Throws Error(output).
  void add(const Image& image, const Display& display);
  /// Ends the film. Throws Error(output).
  void finish();

 private:
  void start(int width, int height);
  [[noreturn]] void fail(const std::string& why);

  std::string path_;
  double frame_rate_;
  std::optional<HiddenFile> file_;
  std::FILE* ffmpeg_ = nullptr;
};

/// Whether a file of this name is a film that ffmpeg writes.
bool is_movie_name(const std::string& path);

bool can_make_movies();

}  // namespace psivox
