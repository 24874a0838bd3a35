#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "psivox/scene.h"

namespace psivox {

/// A view of an OpenColorIO config. It takes the place of the tone map and of sRGB's curve.
struct OcioView {
  std::string config;  ///< file; empty: none
  std::string display;
  std::string view;
  std::string space;  ///< colour space of the picture's light, or a role
  bool operator==(const OcioView&) const = default;
};

/// How sRGB codes show radiance. Pictures of linear radiance ignore it.
struct Display {
  double exposure = 0;  ///< powers of 2
  ToneMap tone_map = ToneMap::none;
  OcioView ocio{};

  double factor() const { return std::exp2(exposure); }
  bool operator==(const Display&) const = default;
};

/// One named plane or group of planes of a picture, row-major from the top left pixel, interleaved.
struct Layer {
  std::string name;                   ///< empty for the picture itself, else `depth`, `steps`, ...
  std::vector<std::string> channels;  ///< {"R","G","B","A"} for the picture; {"depth"} for a layer
  std::vector<float> values;          ///< width * height * channels.size()
};

/// What is between two depths in front of a pixel: a volume sample of OpenEXR, premultiplied. In it
/// attenuation and luminance are constant.
struct DeepSample {
  float z = 0, z_back = 0;  ///< along the view, from the camera [world units]
  float r = 0, g = 0, b = 0, a = 0;
};

/// A deep picture: samples of each pixel from front to back, row-major from the top left pixel.
struct DeepPixels {
  std::vector<std::uint32_t> counts;  ///< of each pixel; empty: the picture is not deep
  std::vector<DeepSample> samples;
};

/// A picture in linear radiance. layers[0] is R G B A, premultiplied.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<Layer> layers;
  std::map<std::string, std::string> metadata;  ///< file attributes, such as `psivox:scene`
  /// Attributes of an EXR for row vectors, as in OpenEXR: m[i][j] is in row i, column j.
  std::map<std::string, glm::mat4> matrices{};
  DeepPixels deep{};  ///< what an EXR holds in place of the layers, if the picture is deep

  std::span<const float> rgba() const { return layers.front().values; }
  std::span<float> rgba() { return layers.front().values; }
  std::size_t pixels() const { return std::size_t(width) * std::size_t(height); }
  /// Number of a pixel, row by row.
  std::size_t index(int x, int y) const {
    return std::size_t(y) * std::size_t(width) + std::size_t(x);
  }
};

/// A picture without other layers, all of one value.
inline Image rgba_image(int width, int height, float value = 0) {
  Image image{width, height, {}, {}};
  image.layers.push_back({"", {"R", "G", "B", "A"}, std::vector<float>(4 * image.pixels(), value)});
  return image;
}

struct WriteOptions {
  /// Writes an EXR's R G B A as 16-bit floats. The largest is 65504, which greater values become.
  /// Other layers stay 32-bit floats.
  bool half = false;
  /// Bits per channel of sRGB codes in PNG and TIFF, 8 or 16. Without it, a PNG has 8, and a TIFF
  /// holds linear 32-bit floats.
  std::optional<int> bits = {};
  /// The display that sRGB codes are for.
  Display display = {};
};

/// What a file of sRGB codes does not show of a picture.
struct Clipping {
  std::size_t clipped = 0;  ///< pixels that are brighter than white
  std::size_t cut = 0;      ///< pixels with more light than their alpha can hold
  double lost = 0;          ///< share of the picture's light that is lost by that, 0 to 1
};

/// The clipping of a picture that write_image would write to `path`; none if the file holds linear
/// radiance. A difference below half a code of 8 bits does not count.
Clipping clipping(const Image& image, const std::filesystem::path& path, const WriteOptions& = {});

/// Exposure [powers of 2, in hundredths] at which the display shows 99 % of the pixels that have
/// light at no more than 0.95 of its white; 0 for a black picture. R, G and B count as they are,
/// over black.
double auto_exposure(const Image& image, ToneMap tone_map);

/// Whether a file of this name and these options holds sRGB codes, not linear radiance.
bool holds_codes(const std::filesystem::path& path, const WriteOptions& = {});

/// Writes a picture in the format that the path's extension names:
///
/// | extension    | holds |
/// |---|---|
/// | .exr         | every layer, linear, premultiplied, floats, zip, all metadata |
/// | .png         | R G B A as sRGB codes, un-premultiplied; all metadata |
/// | .tif, .tiff  | R G B A, linear, premultiplied, floats, or with `bits` as in a PNG; metadata |
/// | .jpg, .jpeg  | R G B over black as sRGB codes of 8 bits, quality 95; metadata |
/// | .hdr         | R G B over black, linear, RGBE; negative values become 0 |
/// | .webp        | R G B over black as sRGB codes of 8 bits, quality 100 |
///
/// The path `-` is the standard output, as PNG; `exr:-` and the like name another format.
///
/// TIFF and JPEG hold psivox:scene, psivox:renderer and psivox:version, each up to 60,000 bytes. In
/// an EXR, a layer's only channel has the layer's name; several are named `layer.channel`. sRGB
/// codes with alpha cut radiance above alpha (a glow without opacity) to alpha.
///
/// It writes a file beside the path and renames it, so that none is half-written. Equal images give
/// equal bytes. Returns a sentence for the user that tells what the file cannot hold of the
/// picture, empty if it holds all but what is brighter than white. Throws Error(usage) for another
/// extension and for options that the format does not have, Error(output) if the file cannot be
/// written.
std::string write_image(const Image& image, const std::filesystem::path& path,
                        const WriteOptions& = {});

/// Throws what write_image would throw for this path, these options and a picture of this size,
/// before any work is done. It briefly creates a file in the directory, because permissions alone
/// do not tell.
void check_writable(const std::filesystem::path& path, const WriteOptions& = {}, int width = 1,
                    int height = 1);

/// Whether write_image knows the path's extension.
bool has_picture_extension(const std::filesystem::path& path);

/// What write_image throws for the path's extension; empty if it knows it.
std::string extension_problem(const std::filesystem::path& path);

/// Whether a file of this name holds a picture's psivox:scene: not .hdr and .webp.
bool holds_scene(const std::filesystem::path& path);

/// The view with its config's first display and view, and scene_linear, where none is named. Throws
/// Error(input) if the config cannot be read or has no such display, view or colour space.
OcioView complete_view(const OcioView& view);

/// R G B of a picture, one triple after the other, as the codes of the view's display: 0 to 1, and
/// beyond where the view does not cut. Throws Error(input) as complete_view does.
void show_by(const OcioView& view, std::span<float> rgb);

/// R G B of the picture over black as sRGB codes of 8 bits, row-major from the top left pixel.
std::vector<std::uint8_t> srgb_bytes(const Image& image, const Display& display);

/// Whether write_image writes to the standard output.
bool is_standard_output(const std::filesystem::path& path);

/// Whether write_image writes layers beside the picture to this path: true for .exr.
bool holds_layers(const std::filesystem::path& path);

/// Reads a file of any format that write_image knows, as linear, premultiplied radiance with its
/// string metadata. The file's contents decide the format, not its name. Integers are sRGB codes.
/// layers[0] comes from R G B A or from the grey Y, with A = 1 if there is no alpha; every other
/// channel follows. Of an EXR it reads the first part and the display window, which is 0 where
/// there is no data. NaN and Inf stay. Throws Error(input).
Image read_image(const std::filesystem::path& path);

/// Reads an EXR that may have no picture, R G B A or Y. Without one, the image has the file's other
/// layers alone.
Image read_layers(const std::filesystem::path& path);

/// All attributes of an image file that are texts. Throws Error(input) if the file is no image.
std::map<std::string, std::string> read_metadata(const std::filesystem::path& path);

/// The same of a picture, deep or not, whose pixels are read too: a file that is cut throws.
std::map<std::string, std::string> metadata_of_whole(const std::filesystem::path& path);

/// One of them, empty if absent; names are case-sensitive.
std::string read_metadata(const std::filesystem::path& path, const std::string& key);

/// Difference of two pictures' R G B A. Pixels with a NaN or Inf in either picture, even the same
/// in both, are counted and left out of every other number.
struct Comparison {
  double rms = 0;  ///< over all finite pixels and the four channels
  double max = 0;  ///< largest absolute difference
  int max_x = 0;   ///< where it is, from the top left
  int max_y = 0;
  std::string max_channel;  ///< "R", ...; empty if no pixel differs
  std::array<double, 4> channel_rms{};
  std::array<double, 4> channel_mean{};  ///< signed, a - b
  std::size_t not_finite = 0;            ///< pixels where either is NaN or Inf
};

/// Throws Error(input) if the sizes differ.
Comparison compare_images(const Image& a, const Image& b);

/// The difference a - b of two pictures of one size, as an opaque picture. Of R, G and B it shows
/// the channel with the largest difference: blue below 0, red above, full colour from `scale` on.
Image difference_picture(const Image& a, const Image& b, double scale);

/// A scale for difference_picture: the 99th percentile of the differences' magnitudes, or the
/// largest if that is 0.
double difference_scale(const Image& a, const Image& b);

/// OpenImageIO's version, as its library reports it.
std::string openimageio_version();

}  // namespace psivox
