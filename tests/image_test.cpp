#include "psivox/image.h"

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
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <random>
#include <sstream>
#include <thread>

#include "psivox/error.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void put_contents(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

Image picture(int width, int height, std::vector<float> rgba) {
  return {width, height, {{"", {"R", "G", "B", "A"}, std::move(rgba)}}, {}};
}

/// Noise, so that nothing compresses and every pixel is told from its neighbours.
Image noise(int width, int height, std::vector<std::string> extra_layers = {}) {
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

std::vector<std::uint32_t> bits(const std::vector<float>& values) {
  std::vector<std::uint32_t> result;
  for (const float value : values) result.push_back(std::bit_cast<std::uint32_t>(value));
  return result;
}

/// Runs `call`, which has to throw an Error of this code and of one line; returns its text.
std::string error_text(ExitCode code, const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(code)) << text;
    EXPECT_EQ(text.find_first_of("\r\n"), std::string::npos) << text;
    return text;
  }
  ADD_FAILURE() << "no Error was thrown";
  return "";
}

/// The attributes of an EXR header, read without OpenImageIO: it renames some and adds others.
std::map<std::string, std::string> exr_header(const fs::path& path) {
  const std::string bytes = contents(path);
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
std::vector<std::string> exr_channels(const fs::path& path) {
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

/// The bytes that a PNG stores, without OpenImageIO's multiplication by alpha.
std::vector<int> png_bytes(const fs::path& path) {
  OIIO::ImageSpec wish;
  wish.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(path.string(), &wish);
  EXPECT_TRUE(input) << OIIO::geterror();
  if (!input) return {};
  const OIIO::ImageSpec& spec = input->spec();
  EXPECT_EQ(spec.nchannels, 4);
  EXPECT_EQ(spec.format, OIIO::TypeUInt8);
  EXPECT_EQ(spec.get_string_attribute("oiio:ColorSpace"), "sRGB");
  std::vector<std::uint8_t> bytes(spec.image_bytes());
  EXPECT_TRUE(input->read_image(0, 0, 0, 4, OIIO::TypeUInt8, bytes.data()));
  return {bytes.begin(), bytes.end()};
}

/// A file as another program might write it.
void write_with_oiio(const fs::path& path, OIIO::ImageSpec spec, const std::vector<float>& values) {
  const auto output = OIIO::ImageOutput::create(path.string());
  ASSERT_TRUE(output && output->open(path.string(), spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeFloat, values.data()) && output->close());
}

/// What the scene's JSON may contain: quotes, line breaks, tabs, UTF-8, a trailing space; longer
/// than the 255 or 65535 bytes at which formats like to cut.
std::string long_json() {
  std::string text =
      "{\n  \"grid\": \"Dichte \xc3\xa4\xe2\x82\xac\",\t\"path\": \"C:\\\\a\\\"b\",\r\n";
  for (int i = 0; i < 10000; ++i) text += "\"key" + std::to_string(i) + "\": 0.1,\n";
  return text + "} ";
}

class ImageTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "psivox-image-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    directory_ = name;
  }
  void TearDown() override { fs::remove_all(directory_); }

  fs::path file(const std::string& name) const { return directory_ / name; }

  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(directory_)) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  fs::path directory_;
};

using Names = std::vector<std::string>;

TEST_F(ImageTest, ExrKeepsEveryBitOfEveryLayer) {
  // 300 rows are more than one band of the writer; 37 columns align with nothing.
  Image image = noise(37, 300, {"depth", "steps"});
  image.layers.push_back({"normal", {"X", "Y", "Z"}, std::vector<float>(37 * 300 * 3, 0.25f)});
  image.layers.push_back({"debug.cost", {"debug.cost"}, std::vector<float>(37 * 300, 16777215)});
  const std::vector<float> special = {nan,     inf,    -inf,  -0.0f, 1e-42f, -1.5f,
                                      3.4e38f, 1e-38f, 70000, 0,     0,      0};
  std::copy(special.begin(), special.end(), image.rgba().begin());
  image.layers[1].values[5] = inf;
  write_image(image, file("a.exr"));
  EXPECT_EQ(files(), Names{"a.exr"});

  const Image back = read_image(file("a.exr"));
  EXPECT_EQ(back.width, 37);
  EXPECT_EQ(back.height, 300);
  ASSERT_EQ(back.layers.size(), image.layers.size());
  EXPECT_EQ(bits(back.layers[0].values), bits(image.layers[0].values));
  for (const Layer& layer : image.layers) {
    const auto found = std::find_if(back.layers.begin(), back.layers.end(),
                                    [&](const Layer& other) { return other.name == layer.name; });
    ASSERT_NE(found, back.layers.end()) << layer.name;
    EXPECT_EQ(found->channels, layer.channels);
    EXPECT_EQ(bits(found->values), bits(layer.values)) << layer.name;
  }
}

TEST_F(ImageTest, ExrNamesChannelsAfterTheirLayersAndIsZippedFloat) {
  Image image = noise(4, 4, {"depth"});
  image.layers.push_back({"normal", {"X", "Y", "Z"}, std::vector<float>(48)});
  write_image(image, file("a.exr"));
  EXPECT_EQ(exr_channels(file("a.exr")),
            (Names{"A:float", "B:float", "G:float", "R:float", "depth:float", "normal.X:float",
                   "normal.Y:float", "normal.Z:float"}));
  EXPECT_EQ(exr_header(file("a.exr")).at("compression"), std::string(1, '\3'));  // ZIP_COMPRESSION
}

TEST_F(ImageTest, HalfRoundsThePictureAndLeavesLayersFloat) {
  Image image = noise(5, 5, {"depth"});
  image.rgba()[0] = 1 + 0x1p-11f;  // a tie, between 1 and the next half: to even
  image.rgba()[1] = -inf;
  image.rgba()[2] = nan;
  image.rgba()[4] = 1e6f;
  write_image(image, file("a.exr"), {.half = true});
  EXPECT_EQ(exr_channels(file("a.exr")),
            (Names{"A:half", "B:half", "G:half", "R:half", "depth:float"}));
  const Image back = read_image(file("a.exr"));
  EXPECT_EQ(back.rgba()[0], 1);
  EXPECT_EQ(back.rgba()[1], -inf);
  EXPECT_TRUE(std::isnan(back.rgba()[2]));
  EXPECT_EQ(back.rgba()[4], inf);
  for (std::size_t i = 5; i < back.rgba().size(); ++i) {
    // Half has 11 significant bits: half a unit in the last place is 2^-11 of a value below 1 at
    // most.
    EXPECT_NEAR(back.rgba()[i], image.rgba()[i], 0x1p-12f);
  }
  EXPECT_EQ(back.layers[1].values, image.layers[1].values);
}

TEST_F(ImageTest, MetadataReturnsByteForByteFromBothFormats) {
  Image image = noise(2, 2);
  image.metadata = {{"psivox:scene", long_json()},
                    {"psivox:renderer", "llvmpipe (LLVM 15.0.6, 256 bits)"},
                    {"Software", "psivox 1.0"}};
  for (const char* name : {"a.exr", "a.png"}) {
    SCOPED_TRACE(name);
    write_image(image, file(name));
    for (const auto& [key, value] : image.metadata) {
      EXPECT_TRUE(read_metadata(file(name), key) == value) << key;
    }
    EXPECT_EQ(read_metadata(file(name), "psivox:absent"), "");
    EXPECT_TRUE(read_image(file(name)).metadata == image.metadata);
  }
  // Under these very names for exrheader and other readers too.
  for (const auto& [key, value] : image.metadata) {
    EXPECT_TRUE(exr_header(file("a.exr")).at(key) == value) << key;
  }
}

TEST_F(ImageTest, TwoWritesAreByteIdenticalThoughTimePasses) {
  Image image = noise(64, 64, {"depth"});
  image.metadata["psivox:scene"] = "{}";
  for (const char* extension : {".exr", ".png"}) {
    write_image(image, file("a").replace_extension(extension));
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // dates count in seconds
    write_image(image, file("b").replace_extension(extension));
    EXPECT_TRUE(contents(file("a").replace_extension(extension)) ==
                contents(file("b").replace_extension(extension)))
        << extension;
  }
  // OpenImageIO writes the attribute in any case; psivox gives it no date.
  EXPECT_EQ(exr_header(file("a.exr")).at("capDate"), "");
}

TEST_F(ImageTest, PngHoldsTheEncodedColourDividedByAlphaOnce) {
  // Linear 0.215861 is sRGB 128/255; the colour is the same at every alpha.
  const float half_grey = 0.215861f;
  write_image(picture(5, 1,
                      {half_grey,
                       1,
                       0,
                       1,  // opaque
                       half_grey / 2,
                       0.5f,
                       0,
                       0.5f,  // alpha stays linear: 128
                       half_grey * 0.1f,
                       0.1f,
                       0,
                       0.1f,  // 25.5
                       0,
                       0,
                       0,
                       0,  // empty
                       0.002f,
                       0,
                       0.25f,
                       0.25f}),
              file("a.png"));
  EXPECT_EQ(png_bytes(file("a.png")), (std::vector<int>{128, 255, 0, 255,  //
                                                        128, 255, 0, 128,  //
                                                        128, 255, 0, 26,   //
                                                        0, 0, 0, 0,        //
                                                        // 255 (1.055 * 0.008^(1/2.4) - 0.055)
                                                        22, 0, 255, 64}));
}

TEST_F(ImageTest, PngCutsGlowToAlphaAndReplacesWhatIsNoNumber) {
  write_image(picture(4, 1,
                      {3, 0.5f, -1, 1,     // bright and negative
                       0.7f, 0.7f, 0, 0,   // glow without opacity is lost
                       nan, inf, 0, 0.5f,  //
                       1, 0, 0, nan}),
              file("a.png"));
  EXPECT_EQ(png_bytes(file("a.png")), (std::vector<int>{255, 188, 0, 255,  //
                                                        0, 0, 0, 0,        //
                                                        0, 255, 0, 128,    //
                                                        0, 0, 0, 0}));
}

TEST_F(ImageTest, PngReadsBackLinearAndPremultiplied) {
  std::vector<float> rgba;
  for (int i = 0; i < 256; ++i) {
    const float alpha = static_cast<float>(i % 16 + 1) / 16;
    const float colour = static_cast<float>(i) / 255;
    rgba.insert(rgba.end(), {colour * alpha, colour * colour * alpha, alpha, alpha});
  }
  write_image(picture(16, 16, rgba), file("a.png"));
  const Image back = read_image(file("a.png"));
  for (std::size_t i = 0; i < rgba.size(); ++i) {
    // Half a code value: 1/510, times the steepest slope of the decoding, 2.4 / 1.055, for colour,
    // and once more for alpha, of which colour is a multiple.
    EXPECT_NEAR(back.rgba()[i], rgba[i], 2.4 / 1.055 / 510 + 1.0 / 510) << i;
  }
  // What came from a PNG becomes the same PNG.
  write_image(back, file("b.png"));
  EXPECT_EQ(png_bytes(file("b.png")), png_bytes(file("a.png")));
}

TEST_F(ImageTest, PngLeavesOutExtraLayers) {
  write_image(noise(3, 2, {"depth"}), file("a.png"));
  EXPECT_EQ(read_image(file("a.png")).layers.size(), 1u);
}

TEST_F(ImageTest, ReadsPicturesOfOtherPrograms) {
  OIIO::ImageSpec spec(2, 1, 1, OIIO::TypeHalf);
  spec.channelnames = {"Y"};
  write_with_oiio(file("grey.exr"), spec, {0.25f, 2});
  EXPECT_EQ(read_image(file("grey.exr")).layers[0].values,
            (std::vector<float>{0.25f, 0.25f, 0.25f, 1, 2, 2, 2, 1}));

  spec = OIIO::ImageSpec(1, 1, 3, OIIO::TypeFloat);
  write_with_oiio(file("rgb.exr"), spec, {1, 2, 3});
  EXPECT_EQ(read_image(file("rgb.exr")).layers[0].values, (std::vector<float>{1, 2, 3, 1}));

  // The format is the contents', not the name's.
  fs::copy(file("rgb.exr"), file("rgb.png"));
  EXPECT_EQ(read_image(file("rgb.png")).layers[0].values, (std::vector<float>{1, 2, 3, 1}));

  // A crop of a 3x2 picture: its pixels lie in the display window, the rest is empty.
  spec.x = 1;
  spec.y = 1;
  spec.full_width = 3;
  spec.full_height = 2;
  write_with_oiio(file("crop.exr"), spec, {1, 2, 3});
  const Image crop = read_image(file("crop.exr"));
  EXPECT_EQ(crop.width, 3);
  EXPECT_EQ(crop.height, 2);
  std::vector<float> expected(24, 0.0f);
  std::copy_n(std::vector<float>{1, 2, 3, 1}.begin(), 4, expected.begin() + 16);
  EXPECT_EQ(crop.layers[0].values, expected);

  // Overscan: the other way round.
  spec = OIIO::ImageSpec(3, 1, 3, OIIO::TypeFloat);
  spec.x = -1;
  spec.full_width = 1;
  write_with_oiio(file("overscan.exr"), spec, {1, 1, 1, 2, 2, 2, 3, 3, 3});
  EXPECT_EQ(read_image(file("overscan.exr")).layers[0].values, (std::vector<float>{2, 2, 2, 1}));

  spec = OIIO::ImageSpec(1, 1, 1, OIIO::TypeUInt16);
  spec.attribute("oiio:ColorSpace", "sRGB");
  write_with_oiio(file("grey16.png"), spec, {0.5f});
  EXPECT_NEAR(read_image(file("grey16.png")).rgba()[2], 0.214041f, 1e-5f);  // 1/65535 and rounding

  spec = OIIO::ImageSpec(1, 1, 3, OIIO::TypeUInt16);
  spec.attribute("oiio:ColorSpace", "Linear");
  write_with_oiio(file("linear.png"), spec, {0.5f, 0.25f, 1});
  EXPECT_NEAR(read_image(file("linear.png")).rgba()[1], 0.25f, 1e-5f);
}

TEST_F(ImageTest, ReadingNamesTheFileAndTheReason) {
  const auto read_text = [&](const std::string& name) {
    const fs::path path = name.empty() ? directory_ : file(name);
    const std::string text = error_text(ExitCode::input, [&] { read_image(path); });
    EXPECT_NE(text.find("cannot read '" + path.string() + "': "), std::string::npos) << text;
    return text;
  };
  EXPECT_NE(read_text("absent.exr").find("no such file"), std::string::npos);
  EXPECT_NE(read_text("").find("directory"), std::string::npos);
  put_contents(file("empty.exr"), "");
  EXPECT_NE(read_text("empty.exr").find("neither an EXR nor a PNG"), std::string::npos);
  put_contents(file("text.png"), "P6 1 1 255 abc");
  EXPECT_NE(read_text("text.png").find("neither an EXR nor a PNG"), std::string::npos);
  error_text(ExitCode::input, [&] { read_metadata(file("text.png"), "psivox:scene"); });

  OIIO::ImageSpec spec(1, 1, 1, OIIO::TypeFloat);
  spec.channelnames = {"depth"};
  write_with_oiio(file("depth.exr"), spec, {1});
  EXPECT_NE(read_text("depth.exr").find("but depth"), std::string::npos);
}

TEST_F(ImageTest, AFileCutShortIsAnErrorAndPrintsNothingItself) {
  const Image image = noise(48, 40, {"depth"});
  testing::internal::CaptureStderr();
  for (const char* name : {"a.exr", "a.png"}) {
    write_image(image, file(name));
    const std::string whole = contents(file(name));
    for (const std::size_t size : {std::size_t{8}, std::size_t{30}, std::size_t{200},
                                   std::size_t{380}, whole.size() / 2, whole.size() - 1}) {
      put_contents(file("cut"), whole.substr(0, size));
      const std::string text = error_text(ExitCode::input, [&] { read_image(file("cut")); });
      EXPECT_NE(text.find("cut'"), std::string::npos) << name << " of " << size << ": " << text;
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(ImageTest, EveryDamagedByteOfAPngIsAnError) {
  write_image(noise(4, 4), file("a.png"));
  const std::string whole = contents(file("a.png"));
  testing::internal::CaptureStderr();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    put_contents(file("damaged"), damaged);
    error_text(ExitCode::input, [&] { read_image(file("damaged")); });
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(ImageTest, EveryDamagedByteOfAnExrIsAnErrorOrAPicture) {
  write_image(noise(4, 4), file("a.exr"));
  const std::string whole = contents(file("a.exr"));
  const std::size_t data_window = whole.find("dataWindow") + 21;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    // Millions of columns are legal and zip needs no bytes for them: that costs memory, no more.
    if (i >= data_window && i < data_window + 16) continue;
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    put_contents(file("damaged"), damaged);
    try {
      read_image(file("damaged"));
    } catch (const Error& error) {
      EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(ExitCode::input)) << error.what();
    }
  }
}

TEST_F(ImageTest, AnUnknownExtensionIsAUsageErrorThatNamesTheKnown) {
  for (const char* name : {"a.jpg", "a", "a.exr.bak", ".exr"}) {
    for (const auto& call : {std::function([&] { check_writable(file(name)); }),
                             std::function([&] { write_image(noise(1, 1), file(name)); })}) {
      const std::string text = error_text(ExitCode::usage, call);
      EXPECT_NE(text.find(".exr"), std::string::npos) << text;
      EXPECT_NE(text.find(".png"), std::string::npos) << text;
    }
  }
  EXPECT_TRUE(files().empty());
  write_image(noise(1, 1), file("a.EXR"));
  EXPECT_EQ(read_image(file("a.EXR")).width, 1);
}

TEST_F(ImageTest, AnUnwritableTargetIsFoundBeforeAnyWork) {
  fs::create_directory(file("directory.exr"));
  ASSERT_EQ(mkfifo(file("pipe.exr").c_str(), 0600), 0);
  Names unwritable = {file("absent/a.exr"), file("directory.exr"), file("pipe.exr"),
                      "/proc/psivox.exr"};
  if (geteuid() != 0) {  // root may write everywhere
    put_contents(file("protected.exr"), "old");
    fs::permissions(file("protected.exr"), fs::perms::owner_read);
    fs::create_directory(file("sealed"));
    fs::permissions(file("sealed"), fs::perms::owner_read | fs::perms::owner_exec);
    unwritable.insert(unwritable.end(), {file("protected.exr"), file("sealed/a.exr")});
  }
  const Names before = files();
  for (const std::string& path : unwritable) {
    const std::string checked = error_text(ExitCode::output, [&] { check_writable(path); });
    EXPECT_NE(checked.find(path), std::string::npos) << checked;
    EXPECT_EQ(error_text(ExitCode::output, [&] { write_image(noise(1, 1), path); }), checked);
  }
  EXPECT_EQ(files(), before);
  check_writable(file("good.exr"));
  EXPECT_EQ(files(), before) << "the check left something behind";
}

TEST_F(ImageTest, ARelativeNameIsWrittenWhereItPoints) {
  const fs::path before = fs::current_path();
  fs::current_path(directory_);
  EXPECT_NO_THROW(check_writable("a.exr"));
  EXPECT_NO_THROW(write_image(noise(1, 1), "a.exr"));
  fs::current_path(before);
  EXPECT_EQ(files(), Names{"a.exr"});
}

TEST_F(ImageTest, ASymbolicLinkIsFollowedNotReplaced) {
  fs::create_directory(file("store"));
  put_contents(file("store/real.exr"), "old");
  fs::create_symlink("store/real.exr", file("link.exr"));
  write_image(noise(3, 1), file("link.exr"));
  EXPECT_TRUE(fs::is_symlink(file("link.exr")));
  EXPECT_EQ(read_image(file("store/real.exr")).width, 3);
}

TEST_F(ImageTest, AFullDiskIsAnErrorAndLeavesTheOldFile) {
  // A limit on the size of files fails a write as a full disk does: short, then with an errno.
  const Image image = noise(64, 64, {"depth"});
  const auto previous_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit previous{};
  getrlimit(RLIMIT_FSIZE, &previous);
  for (const char* name : {"a.exr", "a.png"}) {
    write_image(image, file("whole").replace_extension(fs::path(name).extension()));
    const auto size = fs::file_size(file("whole").replace_extension(fs::path(name).extension()));
    put_contents(file(name), "old");
    // From the first byte to the last one, which leaves a buffer only when the file is closed.
    for (const auto limit : {std::uintmax_t{0}, std::uintmax_t{100}, size / 2, size - 1}) {
      rlimit tight = previous;
      tight.rlim_cur = limit;
      setrlimit(RLIMIT_FSIZE, &tight);
      const std::string text =
          error_text(ExitCode::output, [&] { write_image(image, file(name)); });
      setrlimit(RLIMIT_FSIZE, &previous);
      EXPECT_NE(text.find(std::strerror(EFBIG)), std::string::npos) << name << limit << text;
      EXPECT_EQ(contents(file(name)), "old");
    }
  }
  std::signal(SIGXFSZ, previous_handler);
  EXPECT_EQ(files(), (Names{"a.exr", "a.png", "whole.exr", "whole.png"}));
}

TEST_F(ImageTest, AMalformedImageIsRefused) {
  Image image = noise(2, 2, {"depth"});
  image.layers[1].values.pop_back();
  EXPECT_NE(error_text(ExitCode::failure, [&] { write_image(image, file("a.exr")); }).find("depth"),
            std::string::npos);
  image = noise(2, 2, {"R"});
  error_text(ExitCode::failure, [&] { write_image(image, file("a.exr")); });
  error_text(ExitCode::failure, [&] { write_image({}, file("a.exr")); });
  EXPECT_TRUE(files().empty());
}

TEST_F(ImageTest, ThreadsMayWriteSideBySide) {
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back(
        [&, i] { write_image(noise(20 + i, 20), file(std::to_string(i) + ".exr")); });
  }
  for (std::thread& thread : threads) thread.join();
  ASSERT_EQ(files().size(), 8u);
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(read_image(file(std::to_string(i) + ".exr")).width, 20 + i);
  }
}

TEST(CompareImages, MeasuresEachChannelAndWhereTheLargestDifferenceIs) {
  Image a = picture(3, 2, std::vector<float>(24, 0.5f));
  const Image b = a;
  a.rgba()[(1 * 3 + 2) * 4 + 1] = 0.25f;   // (2,1) G: -1/4
  a.rgba()[(0 * 3 + 1) * 4 + 3] = 0.625f;  // (1,0) A: +1/8
  const Comparison result = compare_images(a, b);
  EXPECT_DOUBLE_EQ(result.max, 0.25);
  EXPECT_EQ(result.max_x, 2);
  EXPECT_EQ(result.max_y, 1);
  EXPECT_EQ(result.max_channel, "G");
  EXPECT_DOUBLE_EQ(result.rms, std::sqrt((1.0 / 16 + 1.0 / 64) / 24));
  EXPECT_DOUBLE_EQ(result.channel_rms[1], std::sqrt(1.0 / 16 / 6));
  EXPECT_DOUBLE_EQ(result.channel_rms[3], std::sqrt(1.0 / 64 / 6));
  EXPECT_EQ(result.channel_rms[0], 0);
  EXPECT_DOUBLE_EQ(result.channel_mean[1], -0.25 / 6);
  EXPECT_DOUBLE_EQ(result.channel_mean[3], 0.125 / 6);
  EXPECT_EQ(result.not_finite, 0u);
}

TEST(CompareImages, EqualPicturesDifferNowhere) {
  const Image image = noise(5, 5);
  const Comparison result = compare_images(image, image);
  EXPECT_EQ(result.rms, 0);
  EXPECT_EQ(result.max, 0);
  EXPECT_EQ(result.max_channel, "");
}

TEST(CompareImages, CountsPixelsThatAreNotFiniteAndLeavesThemOut) {
  Image a = picture(4, 1, std::vector<float>(16, 1));
  Image b = a;
  a.rgba()[0] = nan;
  a.rgba()[4] = b.rgba()[4] = inf;  // equal in both: still no number
  b.rgba()[11] = -inf;
  b.rgba()[9] = 7;  // in a pixel that is left out
  b.rgba()[12] = 3;
  const Comparison result = compare_images(a, b);
  EXPECT_EQ(result.not_finite, 3u);
  EXPECT_EQ(result.max, 2);
  EXPECT_EQ(result.max_x, 3);
  EXPECT_DOUBLE_EQ(result.rms, 1);  // sqrt(2^2 / (4 channels of 1 pixel))
  EXPECT_DOUBLE_EQ(result.channel_mean[0], -2);

  for (float& value : a.rgba()) value = nan;
  EXPECT_EQ(compare_images(a, b).not_finite, 4u);
  EXPECT_EQ(compare_images(a, b).rms, 0);
}

TEST(CompareImages, KeepsSmallDifferencesOfLargeValues) {
  // The squares overflow float, and the sum of a million of them would lose its last digits.
  const std::size_t pixels = 1 << 18;
  Image a = picture(512, 512, std::vector<float>(pixels * 4, 1e30f));
  Image b = picture(512, 512, std::vector<float>(pixels * 4, 0.0f));
  EXPECT_NEAR(compare_images(a, b).rms / double{1e30f}, 1, 1e-9);
  std::fill(a.rgba().begin(), a.rgba().end(), 1 + 0x1p-23f);
  std::fill(b.rgba().begin(), b.rgba().end(), 1.0f);
  EXPECT_EQ(compare_images(a, b).rms, 0x1p-23);
}

TEST(CompareImages, RefusesDifferentSizes) {
  const std::string text =
      error_text(ExitCode::input, [] { compare_images(noise(4, 2), noise(2, 4)); });
  EXPECT_NE(text.find("4x2"), std::string::npos);
  EXPECT_NE(text.find("2x4"), std::string::npos);
}

TEST(OpenImageIo, ReportsTheVersionOfItsLibrary) {
  std::istringstream version(openimageio_version());
  int major = 0;
  char dot = 0;
  version >> major >> dot;
  EXPECT_EQ(major, OIIO_VERSION_MAJOR);
  EXPECT_EQ(dot, '.');
}

}  // namespace
}  // namespace psivox
