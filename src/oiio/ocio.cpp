#include <OpenImageIO/color.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <algorithm>
#include <map>
#include <memory>
#include <mutex>

#include "base/text.h"
#include "oiio/picture_module.h"

namespace psivox::image_io {
namespace {

Error refused(const OcioView& view, const std::string& why) {
  return Error(ExitCode::input, "--ocio " + in_quotes(view.config) + ": " + one_line(why));
}

/// A config, read once: large ones take seconds.
OIIO::ColorConfig& config_of(const OcioView& view) {
  static std::mutex mutex;
  static std::map<std::string, std::unique_ptr<OIIO::ColorConfig>> configs;
  const std::lock_guard lock(mutex);
  std::unique_ptr<OIIO::ColorConfig>& config = configs[view.config];
  if (config) return *config;
  if (!OIIO::ColorConfig::supportsOpenColorIO())
    throw Error(ExitCode::failure, "--ocio: this OpenImageIO was built without OpenColorIO");
  auto read = std::make_unique<OIIO::ColorConfig>(view.config);
  if (read->has_error()) throw refused(view, read->geterror());
  if (read->getNumDisplays() == 0) throw refused(view, "it has no display");
  config = std::move(read);
  return *config;
}

std::string named_or_first(const OcioView& view, const char* option, const std::string& name,
                           const std::string& first, const std::vector<std::string>& known) {
  if (name.empty() || std::ranges::find(known, name) != known.end())
    return name.empty() ? first : name;
  throw refused(view, std::string("it has no --ocio-") + option + " " + in_quotes(name) +
                          "; it has " + joined(known, ", "));
}

OIIO::ColorProcessorHandle processor_of(const OcioView& view) {
  OIIO::ColorConfig& config = config_of(view);
  OIIO::ColorProcessorHandle processor =
      config.createDisplayTransform(view.display, view.view, view.space);
  if (processor) return processor;
  throw refused(view, "no way from --ocio-space " + in_quotes(view.space) + " to view " +
                          in_quotes(view.view) + ": " + config.geterror());
}

}  // namespace

OcioView complete_ocio_view(const OcioView& asked) {
  OIIO::ColorConfig& config = config_of(asked);
  OcioView view = asked;
  view.display = named_or_first(asked, "display", asked.display, config.getDefaultDisplayName(),
                                config.getDisplayNames());
  view.view = named_or_first(asked, "view", asked.view, config.getDefaultViewName(view.display),
                             config.getViewNames(view.display));
  if (view.space.empty()) view.space = "scene_linear";
  processor_of(view);
  return view;
}

void show_by_ocio(const OcioView& view, std::span<float> rgb) {
  const OIIO::ColorProcessorHandle processor = processor_of(view);
  // rows of a picture, so that several threads may share them
  constexpr std::size_t width = 1024;
  for (std::size_t at = 0; at < rgb.size();) {
    const std::size_t pixels = (rgb.size() - at) / 3;
    const int columns = int(std::min(width, pixels));
    const int rows = int(pixels / std::size_t(columns));
    OIIO::ImageBuf piece(OIIO::ImageSpec(columns, rows, 3, OIIO::TypeFloat), rgb.data() + at);
    if (!OIIO::ImageBufAlgo::colorconvert(piece, piece, processor.get(), /*unpremult=*/false))
      throw refused(view, piece.geterror());
    at += 3 * std::size_t(columns) * std::size_t(rows);
  }
}

}  // namespace psivox::image_io
