#include "frame_options.h"

namespace psivox {

void FrameOptions::add_to(CommandLine& line) {
  line.add_option("IN.vdb", inputs,
                  "a volume; or a sequence: fire.####.vdb, a folder, or several files")
      ->type_name("")
      ->take_all();
  line.add_option("--frames", frames,
                  "frames of a sequence, such as 1-100, 1-100x2 or 1-10,20 (default: all)")
      ->type_name("A-B[xS]")
      ->group(frames_group);
  line.add_option("--auto-from", auto_from,
                  "frames from which extinction, camera, range, look and exposure are chosen for "
                  "all (default: the first, the middle and the last)")
      ->type_name("all|A-B[xS]")
      ->group(frames_group);
  line.add_option("--missing", missing,
                  "what to do about a frame without a file: refuse to start, leave it out, or take "
                  "the one before it")
      ->type_name("error|skip|hold")
      ->check(CLI::IsMember({"error", "skip", "hold"}).description(""))
      ->capture_default_str()
      ->group(frames_group);
}

}  // namespace psivox
