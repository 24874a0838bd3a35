#include "thumbnail.h"

#include <filesystem>
#include <system_error>

#include "psivox/error.h"
#include "psivox/image.h"
#include "psivox/text.h"
#include "signals.h"

namespace psivox {
namespace {

constexpr std::uintmax_t most_bytes = std::uintmax_t{1} << 30;
constexpr std::uint64_t most_memory = std::uint64_t{1} << 30;
constexpr int most_seconds = 20;
constexpr double tolerance = 4e-3;  ///< a code of 8 bits

}  // namespace

void make_thumbnail(RenderCall& call, Scene& scene) {
  if (call.output.empty() || is_standard_output(call.output) || !call.movie.empty())
    usage("--thumbnail needs a file as -o, and no film");
  std::error_code unknown;  // reading will tell
  const std::uintmax_t bytes = std::filesystem::file_size(scene.input, unknown);
  if (!unknown && bytes > most_bytes)
    throw Error(ExitCode::input, in_quotes(scene.input) + " has " + mebibytes(bytes) +
                                     "; --thumbnail draws files up to " + mebibytes(most_bytes));
  end_after(most_seconds, "--thumbnail: no picture after 20 s");
  call.quiet = true;
  call.thumbnail_name = call.output;
  if (!has_picture_extension(call.output)) call.output += ".png";
  scene.resolution = glm::ivec2(*call.thumbnail);
  if (scene.memory_limit == 0) scene.memory_limit = most_memory;
  if (!scene.tolerance) scene.tolerance = tolerance;
}

void name_thumbnail(const RenderCall& call) {
  if (call.output == call.thumbnail_name) return;
  std::error_code failed;
  std::filesystem::rename(call.output, call.thumbnail_name, failed);
  if (failed)
    throw Error(ExitCode::output,
                "cannot write " + in_quotes(call.thumbnail_name) + ": " + failed.message());
}

}  // namespace psivox
