#include "picture_output.h"

#include "psivox/picture_file.h"

namespace psivox {

bool shows_background(const RenderCall& call) {
  if (call.scene.gives("background")) return false;
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

}  // namespace psivox
