#include "picture_output.h"

#include <cstdio>

#include "notices.h"
#include "psivox/picture_file.h"
#include "psivox/text.h"

namespace psivox {

bool shows_background(const RenderCall& call) {
  return call.output.empty() ? !call.movie.empty() : shows_background(call.output);
}

std::map<std::string, std::string> picture_metadata(const RenderCall& call,
                                                    const std::string& output, const Scene& scene) {
  return picture_metadata(PictureFile{output, call.format, call.layers}, scene);
}

std::vector<std::string> write_picture(const RenderCall& call, const std::string& output,
                                       const View& view, RenderReport& report) {
  std::optional<ColorScale> scale;
  if (view.scene.color_bar) scale = color_scale(view);
  WrittenPicture written =
      write_picture(report.drawn.image, view.scene, scale, report.drawn.stats.renderer,
                    {output, call.format, call.layers});
  report.write_ms = written.write_ms;
  report.clipped = written.clipped;
  report.output_bytes = written.bytes;
  return std::move(written.notices);
}

void put_out(const RenderCall& call, const View& view, RenderReport& report) {
  const auto say = [&](const std::string& notice) {
    if (!call.quiet && !notice.empty()) std::fprintf(stderr, "psivox: %s\n", notice.c_str());
  };
  if (!call.quiet) print_notices(report.drawn.notices);
  say(blank_reason(view, report.drawn.image));
  constexpr double long_write = 1e7;  // [pixels]; a second and more
  const Image& image = report.drawn.image;
  if (double(image.width) * image.height > long_write) say("writing " + in_quotes(call.output));
  const auto notices = write_picture(call, call.output, view, report);
  if (!call.quiet) print_notices(notices);
}

}  // namespace psivox
