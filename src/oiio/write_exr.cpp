#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <vector>

#include "image/encode.h"
#include "oiio/output_proxy.h"
#include "oiio/write.h"

namespace psivox::oiio {
namespace {

OIIO::ImageSpec exr_spec(const Image& image, const WriteOptions& options) {
  OIIO::ImageSpec spec(image.width, image.height, 0, OIIO::TypeFloat);
  for (const Layer& layer : image.layers) {
    const bool picture = &layer == &image.layers.front();
    for (std::size_t c = 0; c < layer.channels.size(); ++c) {
      spec.channelnames.push_back(image_io::exr_channel_name(layer, c));
      // Half's largest number is 65504 and its 11 bits miscount steps above 2048: layers stay
      // float.
      spec.channelformats.push_back(picture && options.half ? OIIO::TypeHalf : OIIO::TypeFloat);
    }
  }
  spec.nchannels = static_cast<int>(spec.channelnames.size());
  spec.alpha_channel = 3;

  // OpenImageIO adds the present time unless there is a date, and two equal renders would differ.
  spec.attribute("DateTime", "");
  for (const auto& [name, value] : image.metadata) spec.attribute(name, value);
  spec.attribute("compression", "zip");
  return spec;
}

}  // namespace

void write_exr(const Image& image, const WriteOptions& options, image_io::OutputFile& file) {
  const OIIO::ImageSpec spec = exr_spec(image, options);
  auto output = OIIO::ImageOutput::create("openexr");
  if (!output) {
    file.commit(false, OIIO::geterror());
    return;
  }
  OutputProxy proxy("picture.exr", file);
  bool ok = output->set_ioproxy(&proxy) && output->open("picture.exr", spec);

  // OpenImageIO takes channels of several types only in the file's own layout. A band at a time
  // bounds the copy; 256 rows are 16 blocks of zip, enough for as many threads.
  constexpr int band_rows = 256;
  const auto pixel_bytes = static_cast<OIIO::stride_t>(spec.pixel_bytes(true));
  const auto row_bytes = pixel_bytes * image.width;
  std::vector<char> band(static_cast<std::size_t>(row_bytes * std::min(band_rows, image.height)));
  for (int y = 0; ok && y < image.height; y += band_rows) {
    const int rows = std::min(band_rows, image.height - y);
    char* destination = band.data();
    std::size_t channel = 0;
    for (const Layer& layer : image.layers) {
      const std::size_t count = layer.channels.size();
      const std::size_t start =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) * count;
      const OIIO::TypeDesc type = spec.channelformat(static_cast<int>(channel));
      ok = ok && OIIO::convert_image(static_cast<int>(count), image.width, rows, 1,
                                     layer.values.data() + start, OIIO::TypeFloat, OIIO::AutoStride,
                                     OIIO::AutoStride, OIIO::AutoStride, destination, type,
                                     pixel_bytes, row_bytes, OIIO::AutoStride);
      destination += count * type.size();
      channel += count;
    }
    ok = ok && output->write_scanlines(y, y + rows, 0, OIIO::TypeUnknown, band.data());
  }
  ok = output->close() && ok;
  const std::string says = output->geterror();
  output.reset();
  file.commit(ok, says);
}

}  // namespace psivox::oiio
