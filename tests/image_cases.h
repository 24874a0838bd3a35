#pragma once

// Shared by the tests of image files: small pictures, raw file contents, a folder for each test.

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <sstream>
#include <thread>

#include "colour/colour.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "scratch.h"

namespace psivox {

namespace fs = std::filesystem;

inline constexpr float inf = std::numeric_limits<float>::infinity();
inline constexpr float nan = std::numeric_limits<float>::quiet_NaN();

inline Image picture(int width, int height, std::vector<float> rgba) {
  return {width, height, {{"", {"R", "G", "B", "A"}, std::move(rgba)}}, {}};
}

/// Noise, so that nothing compresses and all pixels differ.
inline Image noise(int width, int height, std::vector<std::string> extra_layers = {}) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0, 1);
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<float> values(pixels * 4);
  for (float& value : values) value = uniform(random);
  Image image = picture(width, height, values);
  for (const std::string& name : extra_layers) {
    values.resize(pixels);
    for (float& value : values) value = 1000 * uniform(random);
    image.layers.push_back({name, {name}, values});
  }
  return image;
}

/// 256 colours at 16 alphas, none brighter than its alpha.
inline Image colours() {
  std::vector<float> rgba;
  for (int i = 0; i < 256; ++i) {
    const float alpha = static_cast<float>(i % 16 + 1) / 16;
    const float colour = static_cast<float>(i) / 255;
    rgba.insert(rgba.end(), {colour * alpha, colour * colour * alpha, alpha, alpha});
  }
  return picture(16, 16, rgba);
}

/// Largest error of R G B A from sRGB codes of so many bits. It is half a code times the steepest
/// slope of the decoding, 2.4 / 1.055, for colour, and half a code more for alpha, which multiplies
/// colour.
inline double srgb_error(int bits) {
  const double half_code = 0.5 / ((1 << bits) - 1);
  return half_code * 2.4 / 1.055 + half_code;
}

inline double largest_difference(const Image& a, const Image& b) {
  return compare_images(a, b).max;
}

inline std::vector<std::uint32_t> bits(const std::vector<float>& values) {
  std::vector<std::uint32_t> result;
  for (const float value : values) result.push_back(std::bit_cast<std::uint32_t>(value));
  return result;
}

/// The attributes of an EXR header, read without OpenImageIO: it renames some and adds others.
inline std::map<std::string, std::string> exr_header(const fs::path& path) {
  const std::string bytes = test::file_bytes(path);
  std::map<std::string, std::string> attributes;
  std::size_t at = 8;
  while (at < bytes.size() && bytes[at] != 0) {
    const std::string name = bytes.c_str() + at;
    at += name.size() + 1;
    at += std::strlen(bytes.c_str() + at) + 1;
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + at, 4);
    attributes[name] = bytes.substr(at + 4, size);
    at += 4 + size;
  }
  return attributes;
}

/// "name:type" of each channel in the file's own order, which is alphabetical.
inline std::vector<std::string> exr_channels(const fs::path& path) {
  const std::string list = exr_header(path).at("channels");
  std::vector<std::string> channels;
  for (std::size_t at = 0; list[at] != 0;) {
    const std::string name = list.c_str() + at;
    at += name.size() + 1;
    channels.push_back(name + (list[at] == 1 ? ":half" : list[at] == 2 ? ":float" : ":uint"));
    at += 16;
  }
  return channels;
}

/// The bytes that a PNG or TIFF stores, without OpenImageIO's multiplication by alpha.
inline std::vector<int> stored_bytes(const fs::path& path) {
  OIIO::ImageSpec wish;
  wish.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(path.string(), &wish);
  EXPECT_TRUE(input) << OIIO::geterror();
  if (!input) return {};
  const OIIO::ImageSpec& spec = input->spec();
  EXPECT_EQ(spec.nchannels, 4);
  EXPECT_EQ(spec.format, OIIO::TypeUInt8);
  std::vector<std::uint8_t> bytes(spec.image_bytes());
  EXPECT_TRUE(input->read_image(0, 0, 0, 4, OIIO::TypeUInt8, bytes.data()));
  return {bytes.begin(), bytes.end()};
}

/// A file of each format that psivox writes.
inline constexpr const char* every_format[] = {"a.exr", "a.png", "a.tif",
                                               "a.jpg", "a.hdr", "a.webp"};

/// A file as another program could write it.
inline void write_with_oiio(const fs::path& path, OIIO::ImageSpec spec,
                            const std::vector<float>& values) {
  const auto output = OIIO::ImageOutput::create(path.string());
  ASSERT_TRUE(output && output->open(path.string(), spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeFloat, values.data()) && output->close());
}

/// Difficult contents of the scene's JSON: quotes, line breaks, tabs, UTF-8, a trailing space. It
/// is longer than 255 and 65535 bytes, at which formats tend to truncate.
inline std::string long_json() {
  std::string text =
      "{\n  \"grid\": \"Dichte \xc3\xa4\xe2\x82\xac\",\t\"path\": \"C:\\\\a\\\"b\",\r\n";
  for (int i = 0; i < 10000; ++i) text += "\"key" + std::to_string(i) + "\": 0.1,\n";
  return text + "} ";
}

class ImageTest : public ::testing::Test {
 protected:
  fs::path file(const std::string& name) const { return directory_ / name; }

  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(directory_)) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  fs::path directory_ = test::empty_scratch_dir();
};

using Names = std::vector<std::string>;

}  // namespace psivox
