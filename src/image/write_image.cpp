#include <set>
#include <string>

#include "encode.h"
#include "format.h"
#include "psivox/error.h"
#include "psivox/image.h"

namespace psivox {
namespace {

/// The format that `path` asks for. Throws Error(usage) if the options do not suit it.
image_io::Format format_of(const std::filesystem::path& path, const WriteOptions& options) {
  const image_io::Format format = image_io::format_from_extension(path);
  const auto refuse = [&](const std::string& why) {
    throw Error(ExitCode::usage, "cannot write '" + path.string() + "': " + why);
  };
  if (options.half && format != image_io::Format::exr) refuse("--half needs an .exr as output");
  if (options.bits && format != image_io::Format::png) refuse("--bits needs a .png as output");
  if (options.bits && *options.bits != 8 && *options.bits != 16) refuse("--bits is 8 or 16");
  return format;
}

/// A wrong size would read past the values, and a name twice would lose a channel silently.
void check_layers(const Image& image, const std::filesystem::path& path) {
  const auto fail = [&](const std::string& why) {
    throw Error(ExitCode::failure, "cannot write '" + path.string() + "': " + why);
  };
  if (image.width <= 0 || image.height <= 0) fail("the picture is empty");
  const auto pixels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (image.layers.empty() || !image.layers.front().name.empty() ||
      image.layers.front().channels != std::vector<std::string>{"R", "G", "B", "A"}) {
    fail("the first layer is not R G B A");
  }
  std::set<std::string> names;
  for (const Layer& layer : image.layers) {
    if (layer.values.size() != pixels * layer.channels.size()) {
      fail("layer '" + layer.name + "' does not have the picture's size");
    }
    for (std::size_t c = 0; c < layer.channels.size(); ++c) {
      const std::string name = image_io::exr_channel_name(layer, c);
      if (!names.insert(name).second) fail("two channels are named '" + name + "'");
    }
  }
}

}  // namespace

std::string image_io::exr_channel_name(const Layer& layer, std::size_t channel) {
  if (layer.name.empty()) return layer.channels[channel];
  if (layer.channels.size() == 1) return layer.name;
  return layer.name + "." + layer.channels[channel];
}

void write_image(const Image& image, const std::filesystem::path& path,
                 const WriteOptions& options) {
  const image_io::Format format = format_of(path, options);
  check_layers(image, path);
  image_io::OutputFile file(path);
  switch (format) {
    case image_io::Format::exr:
      image_io::write_exr(image, options, file);
      break;
    case image_io::Format::png:
      image_io::write_png(image, options, file);
      break;
  }
}

void check_writable(const std::filesystem::path& path, const WriteOptions& options) {
  format_of(path, options);
  // Permissions alone do not tell (root, a read-only or full file system): a file is created.
  const image_io::OutputFile probe(path);
}

bool holds_layers(const std::filesystem::path& path) {
  return image_io::format_from_extension(path) == image_io::Format::exr;
}

}  // namespace psivox
