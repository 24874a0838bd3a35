#include <OpenImageIO/imageio.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "image/encode.h"
#include "image/srgb.h"
#include "oiio/output_proxy.h"
#include "oiio/write.h"

namespace psivox::oiio {
namespace {

/// To [0, 1]; NaN to 0.
float clamped(float value) { return value > 0 ? (value < 1 ? value : 1.0f) : 0.0f; }

std::uint8_t quantised(float value) { return static_cast<std::uint8_t>(value * 255 + 0.5f); }

std::vector<std::uint8_t> png_pixels(std::span<const float> rgba) {
  std::vector<std::uint8_t> pixels(rgba.size());
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const float alpha = clamped(rgba[i + 3]);
    for (std::size_t c = 0; c < 3 && alpha > 0; ++c) {
      pixels[i + c] = quantised(image_io::srgb_from_linear(clamped(rgba[i + c] / alpha)));
    }
    pixels[i + 3] = quantised(alpha);
  }
  return pixels;
}

}  // namespace

void write_png(const Image& image, image_io::OutputFile& file) {
  OIIO::ImageSpec spec(image.width, image.height, 4, OIIO::TypeUInt8);
  for (const auto& [name, value] : image.metadata) spec.attribute(name, value);
  spec.attribute("oiio:ColorSpace", "sRGB");
  // The pixels below are divided by alpha already; OpenImageIO would do it again.
  spec.attribute("oiio:UnassociatedAlpha", 1);

  auto output = OIIO::ImageOutput::create("png");
  if (!output) {
    file.commit(false, OIIO::geterror());
    return;
  }
  const std::vector<std::uint8_t> pixels = png_pixels(image.rgba());
  OutputProxy proxy("picture.png", file);
  bool ok = output->set_ioproxy(&proxy) && output->open("picture.png", spec) &&
            output->write_image(OIIO::TypeUInt8, pixels.data());
  ok = output->close() && ok;
  const std::string says = output->geterror();
  output.reset();
  file.commit(ok, says);
}

}  // namespace psivox::oiio
