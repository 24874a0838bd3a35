#include <algorithm>
#include <cmath>
#include <map>
#include <new>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "base/loaded_module.h"
#include "base/text.h"
#include "base/text_file.h"
#include "colour/colour.h"
#include "formats.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "srgb_codes.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;
using image_io::Format;

float brightest(const float* rgba) { return std::max({rgba[0], rgba[1], rgba[2]}); }

bool through_openimageio(Format format) { return image_io::facts_of(format).openimageio; }

/// Every reason to refuse a file of this name, these options and this size that is known before
/// there is a picture.
Format checked_format(const fs::path& path, const WriteOptions& options, int width, int height) {
  const Format format = image_io::format_from_extension(path);
  const auto refuse = [&](const char* why) {
    throw Error(ExitCode::usage, "cannot write " + in_quotes(path.string()) + ": " + why);
  };
  if (options.half && format != Format::exr) refuse("--half needs an .exr as output");
  if (options.bits && format != Format::png && format != Format::tiff)
    refuse("--bits needs a .png or .tif as output");
  if (options.bits && *options.bits != 8 && *options.bits != 16) refuse("--bits is 8 or 16");

  const image_io::FormatFacts& facts = image_io::facts_of(format);
  if (std::max(width, height) > facts.most_pixels)
    throw image_io::write_error(path, "a " + std::string(facts.extension) + " has at most " +
                                          std::to_string(facts.most_pixels) + " pixels on a side");
  if (through_openimageio(format) && !image_io::picture_files(ExitCode::output).writes(format))
    throw image_io::write_error(path, "this OpenImageIO was built without the format");
  return format;
}

/// A wrong size would read past the values, and a name twice would lose a channel silently.
void check_layers(const Image& image, const fs::path& path) {
  const auto fail = [&](const std::string& why) {
    throw Error(ExitCode::failure, "cannot write " + in_quotes(path.string()) + ": " + why);
  };
  if (image.width <= 0 || image.height <= 0) fail("the picture is empty");
  if (image.layers.empty() || !image.layers.front().name.empty() ||
      image.layers.front().channels != std::vector<std::string>{"R", "G", "B", "A"}) {
    fail("the first layer is not R G B A");
  }
  std::set<std::string> names;
  for (const Layer& layer : image.layers) {
    if (layer.values.size() != image.pixels() * layer.channels.size()) {
      fail("layer '" + layer.name + "' does not have the picture's size");
    }
    for (std::size_t c = 0; c < layer.channels.size(); ++c) {
      const std::string name = image_io::exr_channel_name(layer, c);
      if (!names.insert(name).second) fail("two channels are named '" + name + "'");
    }
  }
}

/// A sentence about light beyond the numbers that the file holds; empty if there is none.
std::string what_is_too_bright(const Image& image, const fs::path& path, Format format,
                               const WriteOptions& options) {
  if (format != Format::hdr && !options.half) return {};
  const float largest = options.half ? image_io::largest_half : image_io::largest_rgbe;
  const auto too_bright = [&](float value) {
    return value > largest && (format == Format::hdr || !std::isinf(value));
  };
  const auto rgba = image.rgba();
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    beyond += too_bright(rgba[i]) || too_bright(rgba[i + 1]) || too_bright(rgba[i + 2]);
  if (beyond == 0) return {};
  return in_quotes(path.string()) + ": " + std::to_string(beyond) + " of " +
         std::to_string(rgba.size() / 4) + " pixels are brighter than " +
         formatted("%.4g", largest) + ", the largest number that it holds" +
         (options.half ? "; leave out --half" : "");
}

/// A sentence for the user; empty if the file holds the whole picture.
std::string what_is_lost(const Image& image, const fs::path& path, Format format,
                         const WriteOptions& options) {
  const auto rgba = image.rgba();
  const std::string all = std::to_string(rgba.size() / 4);
  if (image_io::facts_of(format).alpha) {
    const Clipping loss = clipping(image, path, options);
    if (loss.cut == 0) return {};
    return in_quotes(path.string()) + " loses " + percent_text(loss.lost) +
           " of the picture's light: " + std::to_string(loss.cut) + " of " + all +
           " pixels glow more than they cover, which alpha cannot hold; give --background R,G,B, "
           "or write an .exr";
  }
  std::size_t lost = 0;
  for (std::size_t i = 3; i < rgba.size(); i += 4) lost += 1 > rgba[i] + half_code<float>;
  if (lost == 0) return {};
  return in_quotes(path.string()) + " has no alpha: " + std::to_string(lost) + " of " + all +
         " pixels are not opaque and stand over black; --background R,G,B sets another colour";
}

const image_io::PictureFiles* load_module(ExitCode if_missing) {
  std::string problem;
  const auto get = reinterpret_cast<image_io::GetPictureFiles>(
      load_symbol(PSIVOX_OIIO_MODULE, image_io::picture_files_symbol, /*shared=*/false, problem));
  if (get) return get();
  throw Error(if_missing,
              image_io::one_line("cannot load the module that reads and writes pictures: " +
                                 problem + "; .exr and .png need none"));
}

/// Reads the picture, or layers alone if `needs_picture` is not set.
Image read_any(const fs::path& path, Format format, bool needs_picture) {
  try {
    if (format == Format::exr) return image_io::read_exr(path, needs_picture);
    if (format == Format::png) return image_io::read_png(path);
    return image_io::picture_files(ExitCode::failure).read(path, format);
  } catch (const std::bad_alloc&) {
    throw image_io::read_error(path, "there is not enough memory for its pixels");
  }
}

}  // namespace

Clipping clipping(const Image& image, const fs::path& path, const WriteOptions& options) {
  Clipping result;
  if (!holds_codes(path, options)) return result;
  const bool has_alpha = image_io::facts_of(image_io::format_from_extension(path)).alpha;
  const auto factor = float(options.display.factor());
  const auto shown = [&](float radiance) {
    return display_light(factor * radiance, options.display.tone_map);
  };
  const auto rgba = image.rgba();
  double light = 0, lost = 0;
  const bool by_view = !options.display.ocio.config.empty();  // which has a white of its own
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const float alpha = has_alpha ? image_io::clamped(rgba[i + 3]) : 1;
    const float most = brightest(&rgba[i]);
    result.clipped += !by_view && shown(most) > 1 + half_code<float>;
    const bool glows = most > alpha + half_code<float>;
    double missing = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const float wanted = image_io::clamped(shown(rgba[i + c]));
      light += double(wanted);
      if (!glows) continue;
      const float over_black =
          alpha > 0 ? alpha * image_io::clamped(shown(rgba[i + c] / alpha)) : 0;
      if (wanted > over_black + half_code<float>) missing += double(wanted - over_black);
    }
    lost += missing;
    result.cut += missing > 0;
  }
  if (light > 0) result.lost = lost / light;
  return result;
}

double auto_exposure(const Image& image, ToneMap tone_map) {
  constexpr double percentile = 0.99, target = 0.95;
  const auto rgba = image.rgba();
  std::vector<float> lights;
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const float light = brightest(&rgba[i]);
    if (light > 0 && std::isfinite(light)) lights.push_back(light);
  }
  if (lights.empty()) return 0;
  const auto at = std::ptrdiff_t(percentile * double(lights.size() - 1));
  std::nth_element(lights.begin(), lights.begin() + at, lights.end());
  const double bright = double(lights[std::size_t(at)]);
  return std::round(100 * std::log2(radiance_of_display(target, tone_map) / bright)) / 100;
}

std::string image_io::exr_channel_name(const Layer& layer, std::size_t channel) {
  if (layer.name.empty()) return layer.channels[channel];
  if (layer.channels.size() == 1) return layer.name;
  return layer.name + "." + layer.channels[channel];
}

std::string write_image(const Image& image, const fs::path& path, const WriteOptions& options) {
  const Format format = checked_format(path, options, image.width, image.height);
  check_layers(image, path);
  if (options.half && !image.deep.counts.empty())
    throw Error(ExitCode::usage, "--half has too few digits for a deep picture; leave it out");
  if (options.half && std::ranges::count(image.layers, "bound", &Layer::name))
    throw Error(ExitCode::usage, "--half adds an error that layer bound lacks; leave it out");
  image_io::check_target(path);
  if (format == Format::exr)
    image_io::write_exr(image, options, path);
  else if (format == Format::png)
    image_io::write_bytes(path, image_io::png_bytes(image, options));
  else
    image_io::write_bytes(path,
                          image_io::picture_files(ExitCode::output).bytes(image, format, options));
  const std::string too_bright = what_is_too_bright(image, path, format, options);
  return too_bright.empty() ? what_is_lost(image, path, format, options) : too_bright;
}

void check_writable(const fs::path& path, const WriteOptions& options, int width, int height) {
  checked_format(path, options, width, height);
  image_io::check_target(path);
  if (is_standard_output(path)) return;
  try {  // permissions alone do not tell (root, a read-only or full file system)
    const HiddenFile probe(path);
  } catch (const std::system_error& failure) {
    throw image_io::write_error(path, failure.code().message());
  }
}

bool holds_codes(const fs::path& path, const WriteOptions& options) {
  const auto format = image_io::format_of_extension(path);
  if (!format || *format == Format::exr || *format == Format::hdr) return false;
  return *format != Format::tiff || options.bits;
}

bool holds_scene(const fs::path& path) {
  const auto format = image_io::format_of_extension(path);
  return format && *format != Format::hdr && *format != Format::webp;
}

std::vector<std::uint8_t> srgb_bytes(const Image& image, const Display& display) {
  return image_io::srgb_codes<std::uint8_t>(image.rgba(), 3, display);
}

bool has_picture_extension(const fs::path& path) {
  return image_io::format_of_extension(path).has_value();
}

bool is_standard_output(const fs::path& path) {
  const std::string& name = path.native();
  return name == "-" || (name.ends_with(":-") && image_io::format_of_extension(path));
}

bool holds_layers(const fs::path& path) {
  return image_io::format_of_extension(path) == Format::exr;
}

const image_io::PictureFiles& image_io::picture_files(ExitCode if_missing) {
  static const PictureFiles* const loaded = load_module(if_missing);  // tried again if it throws
  return *loaded;
}

Image read_image(const fs::path& path) {
  return read_any(path, image_io::format_from_contents(path), /*needs_picture=*/true);
}

Image read_layers(const fs::path& path) {
  const Format format = image_io::format_from_contents(path);
  if (format != Format::exr)
    throw image_io::read_error(path, "it is no EXR, which alone has layers");
  return read_any(path, format, /*needs_picture=*/false);
}

std::map<std::string, std::string> read_metadata(const fs::path& path) {
  const Format format = image_io::format_from_contents(path);
  if (format == Format::exr) return image_io::read_exr_metadata(path);
  if (format == Format::png) return image_io::read_png(path).metadata;
  return image_io::picture_files(ExitCode::failure).read_metadata(path, format);
}

std::map<std::string, std::string> metadata_of_whole(const fs::path& path) {
  const Format format = image_io::format_from_contents(path);
  if (format == Format::exr) return image_io::metadata_of_whole_exr(path);
  return read_any(path, format, /*needs_picture=*/true).metadata;
}

std::string read_metadata(const fs::path& path, const std::string& key) {
  const auto metadata = read_metadata(path);
  const auto found = metadata.find(key);
  return found == metadata.end() ? std::string() : found->second;
}

OcioView complete_view(const OcioView& view) {
  return image_io::picture_files(ExitCode::failure).complete_view(view);
}

void show_by(const OcioView& view, std::span<float> rgb) {
  image_io::picture_files(ExitCode::failure).show_by(view, rgb);
}

std::string openimageio_version() { return image_io::picture_files(ExitCode::failure).version(); }

}  // namespace psivox
