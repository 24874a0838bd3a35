#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <string_view>

#include "channels.h"
#include "colour/srgb.h"
#include "image/error_text.h"
#include "image/format.h"
#include "image/picture_files.h"
#include "png_chunks.h"
#include "psivox/image.h"

namespace psivox {
namespace {

using image_io::Format;
using image_io::read_error;
using Input = OIIO::ImageInput::unique_ptr;

Input open_image(const std::filesystem::path& path, Format format) {
  if (format == Format::png) image_io::check_png_chunks(path);
  Input input = OIIO::ImageInput::create(format == Format::exr ? "openexr" : "png");
  if (!input) throw read_error(path, OIIO::geterror());
  // A PNG's colours come as they are stored; they are decoded before they are multiplied by alpha.
  OIIO::ImageSpec wish;
  wish.attribute("oiio:UnassociatedAlpha", 1);
  OIIO::ImageSpec spec;
  if (!input->open(path.string(), spec, wish)) throw read_error(path, input->geterror());
  return input;
}

/// What OpenImageIO tells about the file's format, which a copy of the picture should not inherit.
bool is_format_attribute(std::string_view name) {
  return name == "compression" || name.starts_with("oiio:") || name.starts_with("openexr:") ||
         name.starts_with("png:");
}

std::map<std::string, std::string> string_metadata(const OIIO::ImageSpec& spec) {
  std::map<std::string, std::string> metadata;
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    if (attribute.type() == OIIO::TypeString && !is_format_attribute(attribute.name().string())) {
      metadata[attribute.name().string()] = attribute.get_ustring().string();
    }
  }
  return metadata;
}

/// The picture's rectangle, in the coordinates of the stored pixels. 64 bits: an EXR's windows may
/// lie 2^31 apart.
struct Window {
  std::int64_t x = 0;
  std::int64_t y = 0;
  int width = 0;
  int height = 0;
};

/// An EXR's picture is its display window; pixels are stored for its data window. A PNG's offset is
/// a position on paper and moves nothing.
Window picture_window(const OIIO::ImageSpec& spec, Format format) {
  if (format == Format::png) return {0, 0, spec.width, spec.height};
  return {std::int64_t{spec.full_x} - spec.x, std::int64_t{spec.full_y} - spec.y, spec.full_width,
          spec.full_height};
}

/// Headers lie; a picture that fits in no memory is refused before it is allocated. Stored pixels
/// that are not there are found as they are read, but the empty part of a display window needs no
/// byte of the file: it may be 1024 times what is stored, or a megapixel.
void check_size(const std::filesystem::path& path, const OIIO::ImageSpec& spec,
                const Window& window) {
  constexpr double most_values = 0x1p31;  // 8 GiB of floats, 16384x16384 pixels of 8 channels
  const double stored = double(spec.width) * spec.height;
  const double shown = double(window.width) * window.height;
  const int channels = spec.nchannels + 3;  // a grey picture has four when it is read
  if (window.width > 0 && window.height > 0 && shown <= 0x1p20 + 1024 * stored &&
      std::max(stored, shown) * channels <= most_values) {
    return;
  }
  throw read_error(path, "its header is damaged or asks for too much: " +
                             std::to_string(window.width) + "x" + std::to_string(window.height) +
                             " pixels, " + std::to_string(spec.nchannels) + " channels");
}

void linearise_and_premultiply(std::span<float> rgba, const OIIO::ImageSpec& spec) {
  // Without a gAMA chunk OpenImageIO says sRGB, as the PNG specification advises.
  const bool srgb = spec.get_string_attribute("oiio:ColorSpace", "sRGB") == "sRGB";
  const float gamma = spec.get_float_attribute("oiio:Gamma", 1.0f);
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float code = rgba[i + c];
      const float linear = srgb ? linear_from_srgb(code) : std::pow(code, gamma);
      rgba[i + c] = linear * rgba[i + 3];
    }
  }
}

/// The part of the stored pixels that the window shows; 0 where the window has none.
Layer cut_layer(const image_io::LayerSource& source, std::span<const float> stored,
                const OIIO::ImageSpec& spec, const Window& window) {
  const std::size_t count = source.channels.size();
  Layer layer{source.name, source.channels, {}};
  layer.values.resize(static_cast<std::size_t>(window.width) *
                      static_cast<std::size_t>(window.height) * count);
  float* to = layer.values.data();
  for (std::int64_t y = window.y; y < window.y + window.height; ++y) {
    for (std::int64_t x = window.x; x < window.x + window.width; ++x, to += count) {
      if (x < 0 || x >= spec.width || y < 0 || y >= spec.height) continue;
      const auto from = static_cast<std::size_t>((y * spec.width + x) * spec.nchannels);
      for (std::size_t c = 0; c < count; ++c) {
        to[c] = source.indices[c] ? stored[from + *source.indices[c]] : 1.0f;
      }
    }
  }
  return layer;
}

Image read_pixels(OIIO::ImageInput& input, const std::filesystem::path& path, Format format) {
  const OIIO::ImageSpec& spec = input.spec();
  const Window window = picture_window(spec, format);
  check_size(path, spec, window);

  const auto sources = image_io::layers_from_channels(spec.channelnames);
  if (!sources) {
    std::string names;
    for (const std::string& name : spec.channelnames) names += " " + name;
    throw read_error(path, "it has neither the channels R G B nor Y, but" + names);
  }

  // Left uninitialised, so that a lying header costs no memory: the pages come as pixels do.
  const std::size_t count = static_cast<std::size_t>(spec.width) *
                            static_cast<std::size_t>(spec.height) *
                            static_cast<std::size_t>(spec.nchannels);
  const auto stored = std::make_unique_for_overwrite<float[]>(count);
  if (!input.read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, stored.get())) {
    throw read_error(path, input.geterror());
  }

  Image image{window.width, window.height, {}, string_metadata(spec)};
  for (const image_io::LayerSource& source : *sources) {
    image.layers.push_back(cut_layer(source, {stored.get(), count}, spec, window));
  }
  if (format == Format::png) linearise_and_premultiply(image.rgba(), spec);
  return image;
}

Image read_picture(const std::filesystem::path& path) {
  const Format format = image_io::format_from_contents(path);
  const Input input = open_image(path, format);
  try {
    return read_pixels(*input, path, format);
  } catch (const std::bad_alloc&) {
    throw read_error(path, "there is not enough memory for its pixels");
  }
}

std::string read_attribute(const std::filesystem::path& path, const std::string& key) {
  const Input input = open_image(path, image_io::format_from_contents(path));
  const OIIO::ParamValue* attribute = input->spec().find_attribute(key, OIIO::TypeUnknown, true);
  return attribute != nullptr ? attribute->get_string() : std::string();
}

std::string library_version() {
  // major * 10000 + minor * 100 + patch, of the library that runs, not of the header.
  const int version = OIIO::openimageio_version();
  return std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
         std::to_string(version % 100);
}

constexpr image_io::PictureFiles table = {read_picture, read_attribute, library_version};

}  // namespace
}  // namespace psivox

extern "C" const psivox::image_io::PictureFiles* psivox_picture_files() { return &psivox::table; }
