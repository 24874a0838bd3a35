// The module psivox_oiio: pictures that are neither EXR nor PNG, and views of OpenColorIO.

#include <OpenImageIO/color.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "base/text.h"
#include "base/text_file.h"
#include "colour/colour.h"
#include "image/formats.h"
#include "image/srgb_codes.h"

namespace psivox::image_io {
namespace {

/// TIFF and JPEG have a fixed set of tags: psivox's metadata goes into these. HDR and WebP files
/// hold none, as OpenImageIO writes them.
struct Tag {
  const char* key;   ///< of Image::metadata
  const char* name;  ///< OpenImageIO's
};
constexpr Tag tags[] = {{"psivox:scene", "ImageDescription"},
                        {"psivox:renderer", "Model"},
                        {"psivox:folder", "DocumentName"}};

/// `Software` is this and psivox:version, which tells that the other tags are psivox's.
constexpr std::string_view software = "psivox ";

/// Longer texts are left out. A JPEG's segment ends at 65533 bytes, beyond which libjpeg ends the
/// program, and OpenImageIO adds some of its own; it reads a TIFF's text up to 65536.
constexpr std::size_t longest_text = 60000;

// ---- reading ----

using Input = OIIO::ImageInput::unique_ptr;

Input open_picture(const std::filesystem::path& path, Format format) {
  Input input = OIIO::ImageInput::create(facts_of(format).openimageio);
  if (!input) throw read_error(path, OIIO::geterror());
  // sRGB codes come as they are stored; they are decoded before they are multiplied by alpha.
  OIIO::ImageSpec wish;
  wish.attribute("oiio:UnassociatedAlpha", 1);
  OIIO::ImageSpec spec;
  if (!input->open(path.string(), spec, wish)) throw read_error(path, input->geterror());
  return input;
}

/// What OpenImageIO tells about the file's format, which a copy of the picture should not inherit.
bool is_format_attribute(std::string_view name) {
  return name == "compression" || name.starts_with("oiio:");
}

std::map<std::string, std::string> metadata_of(const OIIO::ImageSpec& spec) {
  std::map<std::string, std::string> metadata;
  const std::string writer = spec.get_string_attribute("Software");
  if (writer.starts_with(software)) {
    metadata["psivox:version"] = writer.substr(software.size());
    for (const Tag& tag : tags)
      if (spec.find_attribute(tag.name)) metadata[tag.key] = spec.get_string_attribute(tag.name);
    return metadata;
  }
  for (const OIIO::ParamValue& attribute : spec.extra_attribs)
    if (attribute.type() == OIIO::TypeString && !is_format_attribute(attribute.name().string()))
      metadata[attribute.name().string()] = attribute.get_ustring().string();
  return metadata;
}

/// Makes what a file holds linear and premultiplied. Integers are sRGB codes. Codes that
/// OpenImageIO multiplies by alpha, whatever is asked of it (WebP), are divided by it first.
void linearise_and_premultiply(std::span<float> rgba, const OIIO::ImageSpec& spec) {
  const bool codes = !spec.format.is_floating_point();
  const bool multiplied = spec.get_int_attribute("oiio:UnassociatedAlpha") == 0;
  if (!codes && multiplied) return;
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const float alpha = rgba[i + 3];
    for (std::size_t c = i; c < i + 3; ++c) {
      const float value = multiplied && alpha > 0 ? rgba[c] / alpha : rgba[c];
      rgba[c] = alpha * (codes ? linear_from_srgb(value) : value);
    }
  }
}

Image read_picture(const std::filesystem::path& path, Format format) {
  const Input input = open_picture(path, format);
  const OIIO::ImageSpec& spec = input->spec();
  check_size(path, spec.width, spec.height, double(spec.width) * spec.height, spec.nchannels);
  // Left uninitialised, so that a lying header costs no memory: the pages come as pixels do.
  const std::size_t count =
      std::size_t(spec.width) * std::size_t(spec.height) * std::size_t(spec.nchannels);
  const auto stored = std::make_unique_for_overwrite<float[]>(count);
  const bool read = input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, stored.get());
  // read_image returns true for a TIFF or JPEG that is cut short.
  const std::string failure = input->geterror();
  if (!read || !failure.empty()) throw read_error(path, failure);

  const StoredPixels pixels{spec.width, spec.height, spec.channelnames, {stored.get(), count}};
  if (!have_picture(pixels.channels)) throw no_picture(path, pixels.channels);
  Image image{spec.width, spec.height, layers_of_file(pixels, {0, 0, spec.width, spec.height}),
              metadata_of(spec)};
  linearise_and_premultiply(image.rgba(), spec);
  return image;
}

std::map<std::string, std::string> read_picture_metadata(const std::filesystem::path& path,
                                                         Format format) {
  return metadata_of(open_picture(path, format)->spec());
}

// ---- writing ----

void add_metadata(OIIO::ImageSpec& spec, const std::map<std::string, std::string>& metadata) {
  spec.attribute("DateTime", "");  // or OpenImageIO adds the time: equal pictures are equal files
  const auto version = metadata.find("psivox:version");
  if (version == metadata.end()) return;
  spec.attribute("Software", std::string(software) + version->second);
  for (const Tag& tag : tags) {
    const auto found = metadata.find(tag.key);
    if (found != metadata.end() && found->second.size() <= longest_text)
      spec.attribute(tag.name, found->second);
  }
}

/// Red, green and blue as RGBE can hold them: from 0 to largest_rgbe, 0 for NaN. Mantissas of 8
/// bits share the brightest channel's exponent. OpenImageIO cuts them off, so they are rounded
/// here; a quarter of the last bit keeps its arithmetic from cutting one more.
std::vector<float> rgbe_colours(std::span<const float> rgba) {
  std::vector<float> colours;
  colours.reserve(rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    std::array<float, 3> color;
    for (std::size_t c = 0; c < 3; ++c)
      color[c] = rgba[i + c] > 0 ? std::min(rgba[i + c], largest_rgbe) : 0.0f;
    const float most = std::ranges::max(color);
    int exponent = 0;
    if (256 * std::frexp(most, &exponent) >= 255.5f) ++exponent;
    for (const float value : color) {
      const float mantissa = std::floor(std::ldexp(value, 8 - exponent) + 0.5f);
      colours.push_back(mantissa > 0 ? std::ldexp(mantissa + 0.25f, exponent - 8) : 0);
    }
  }
  return colours;
}

std::string encoded(const Image& image, Format format, OIIO::TypeDesc type, int channels,
                    const void* values) {
  const FormatFacts& facts = facts_of(format);
  OIIO::ImageSpec spec(image.width, image.height, channels, type);
  add_metadata(spec, image.metadata);
  if (channels == 4 && type != OIIO::TypeFloat) spec.attribute("oiio:UnassociatedAlpha", 1);
  if (format == Format::jpeg) {
    spec.attribute("Compression", "jpeg:95");
    spec.attribute("jpeg:subsampling", "4:4:4");  // thin coloured lines keep their colour
  }
  if (format == Format::webp) spec.attribute("Compression", "webp:100");
  OIIO::Filesystem::IOVecOutput memory;
  OIIO::Filesystem::IOProxy* proxy = &memory;
  spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);

  const auto output = OIIO::ImageOutput::create(facts.openimageio);
  if (!output || !output->open("picture" + std::string(facts.extension), spec) ||
      !output->write_image(type, values) || !output->close())
    throw Error(ExitCode::output, "a " + std::string(facts.extension) + " cannot be made: " +
                                      one_line(output ? output->geterror() : OIIO::geterror()));
  return {memory.buffer().begin(), memory.buffer().end()};
}

bool writes(Format format) {
  return OIIO::ImageOutput::create(facts_of(format).openimageio) != nullptr;
}

/// The version of the library that runs; the header may be another.
std::string version() {
  const int number = OIIO::openimageio_version();  // major * 10000 + minor * 100 + patch
  return std::to_string(number / 10000) + "." + std::to_string(number / 100 % 100) + "." +
         std::to_string(number % 100);
}

std::string bytes_of(const Image& image, Format format, const WriteOptions& options) {
  const auto rgba = image.rgba();
  if (format == Format::hdr)
    return encoded(image, format, OIIO::TypeFloat, 3, rgbe_colours(rgba).data());
  if (format != Format::tiff)
    return encoded(image, format, OIIO::TypeUInt8, 3,
                   srgb_codes<std::uint8_t>(rgba, 3, options.display).data());
  if (!options.bits) return encoded(image, format, OIIO::TypeFloat, 4, rgba.data());
  if (*options.bits == 8)
    return encoded(image, format, OIIO::TypeUInt8, 4,
                   srgb_codes<std::uint8_t>(rgba, 4, options.display).data());
  return encoded(image, format, OIIO::TypeUInt16, 4,
                 srgb_codes<std::uint16_t>(rgba, 4, options.display).data());
}

// ---- views ----

Error refused(const OcioView& view, const std::string& why) {
  return Error(ExitCode::input, "--ocio " + in_quotes(view.config) + ": " + one_line(why));
}

/// Does first in a process of its own, under limits, what a config may make endless: transforms
/// that lead in circles, lists that repeat each other, a pipe in the place of a table. Throws
/// Error(input) if that process does not reach the end.
void try_apart(const OcioView& view, const std::function<void()>& work) {
  constexpr int seconds = 10, most_seconds = 60;  // of the processor, and with waiting
  constexpr rlim_t memory = rlim_t{2} << 30;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw refused(view, "there is no pipe to a process for it");
  const pid_t apart = ::fork();
  if (apart == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    std::uint64_t pages = 0;  // the sixth number: what this process has already
    std::ifstream statm("/proc/self/statm");
    for (int n = 0; n < 6; ++n) statm >> pages;
    const rlimit most{memory + pages * rlim_t(::sysconf(_SC_PAGESIZE)), RLIM_INFINITY};
    const rlimit time{seconds, seconds}, none{0, 0};
    ::setrlimit(RLIMIT_DATA, &most);
    ::setrlimit(RLIMIT_CPU, &time);
    ::setrlimit(RLIMIT_CORE, &none);
    ::alarm(most_seconds);
    std::set_new_handler([] { ::_exit(1); });
    try {
      work();
    } catch (const std::exception&) {  // the program meets it again, and says it
    }
    ::_exit(::write(ends[1], "", 1) == 1 ? 0 : 1);
  }
  ::close(ends[1]);
  char end = 0;
  ssize_t count = -1;
  while (apart > 0 && (count = ::read(ends[0], &end, 1)) < 0 && errno == EINTR) continue;
  ::close(ends[0]);
  if (apart > 0) ::waitpid(apart, nullptr, 0);
  if (count != 1)
    throw refused(view, "OpenColorIO crashes, or takes more than 10 s or 2 GiB, to read it");
}

/// Keeps outputs off the files that a config may name: all of its words that are files, seen from
/// its folder and from those that it names. Throws Error(input) for a pipe or a device.
void expect_named_files(const OcioView& view, std::string text) {
  namespace fs = std::filesystem;
  constexpr std::size_t most_folders = 32;
  for (char& letter : text)
    if (std::strchr("\n\r,:[]{}\"'", letter)) letter = '\n';
  std::set<std::string> words;
  for (const std::string& line : split(text, '\n'))
    if (const std::size_t first = line.find_first_not_of(" \t-"); first != line.npos)
      words.insert(line.substr(first, line.find_last_not_of(" \t") + 1 - first));
  const fs::path own = fs::path(view.config).parent_path();
  std::vector<fs::path> folders{own};
  std::error_code none;
  for (const std::string& word : words)
    if (folders.size() < most_folders && fs::is_directory(own / word, none))
      folders.push_back(own / word);
  for (const std::string& word : words)
    for (const fs::path& folder : folders) {
      const fs::file_status status = fs::status(folder / word, none);
      if (fs::is_regular_file(status))
        InputProtection::expect(folder / word);
      else if (fs::exists(status) && !fs::is_directory(status))
        throw refused(view, "it names " + in_quotes(word) + ", which is a pipe or a device");
    }
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
  if (std::string why; !view.config.starts_with("ocio://")) {  // OpenColorIO's own
    const int file = open_input(view.config, why);
    if (file < 0) throw refused(view, why);
    ::close(file);
    std::error_code unknown;  // a pipe can be read but once
    if (std::filesystem::is_regular_file(view.config, unknown)) {
      expect_named_files(view, read_text(view.config, "config"));
      try_apart(view, [&] { OIIO::ColorConfig tried(view.config); });
    }
  }
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
  const auto make = [&] {
    return config.createDisplayTransform(view.display, view.view, view.space);
  };
  static std::mutex mutex;
  static std::set<std::vector<std::string>> tried;
  std::unique_lock lock(mutex);
  const std::vector<std::string> names{view.config, view.display, view.view, view.space};
  if (!tried.contains(names)) try_apart(view, make);
  tried.insert(names);
  lock.unlock();
  OIIO::ColorProcessorHandle processor = make();
  if (processor) return processor;
  throw refused(view, "no way from --ocio-space " + in_quotes(view.space) + " to view " +
                          in_quotes(view.view) + ": " + config.geterror());
}

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

constexpr PictureFiles table = {read_picture,       read_picture_metadata, writes, bytes_of,
                                complete_ocio_view, show_by_ocio,          version};

}  // namespace
}  // namespace psivox::image_io

extern "C" const psivox::image_io::PictureFiles* psivox_picture_files() {
  return &psivox::image_io::table;
}
