// Contents of EXR and PNG files, written and read.
#include "image_cases.h"
#include "scratch.h"
#include "thrown.h"

namespace psivox {
namespace {

TEST_F(ImageTest, ExrKeepsEveryBitOfEveryLayer) {
  // 300 rows exceed one band of the writer; 37 columns align with nothing.
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
  image.rgba()[0] = 1 + 0x1p-11f;  // a tie between 1 and the next half: rounds to even
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
  EXPECT_EQ(back.rgba()[4], 65504);
  for (std::size_t i = 5; i < back.rgba().size(); ++i) {
    // Half has 11 significant bits: half a unit in the last place is at most 2^-11 for a value
    // below 1.
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
  // exrheader and other readers know these names.
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
    EXPECT_TRUE(test::file_bytes(file("a").replace_extension(extension)) ==
                test::file_bytes(file("b").replace_extension(extension)))
        << extension;
  }
  EXPECT_FALSE(exr_header(file("a.exr")).contains("capDate"));
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
  EXPECT_EQ(stored_bytes(file("a.png")), (std::vector<int>{128, 255, 0, 255,  //
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
  EXPECT_EQ(stored_bytes(file("a.png")), (std::vector<int>{255, 188, 0, 255,  //
                                                           0, 0, 0, 0,        //
                                                           0, 255, 0, 128,    //
                                                           0, 0, 0, 0}));
}

TEST_F(ImageTest, PngReadsBackLinearAndPremultiplied) {
  for (const int bits : {8, 16}) {
    SCOPED_TRACE(bits);
    write_image(colours(), file("a.png"), {.bits = bits});
    EXPECT_EQ(test::file_bytes(file("a.png"))[24],
              bits);  // after the signature, IHDR's name and the size
    const Image back = read_image(file("a.png"));
    EXPECT_LE(largest_difference(back, colours()), srgb_error(bits));
    // A picture read from a PNG writes the same PNG.
    write_image(back, file("b.png"), {.bits = bits});
    EXPECT_TRUE(test::file_bytes(file("b.png")) == test::file_bytes(file("a.png")));
  }
}

TEST_F(ImageTest, OptionsThatAFormatDoesNotHaveAreUsageErrors) {
  for (const auto& [name, options, part] :
       {std::tuple("a.png", WriteOptions{.half = true}, "needs an .exr"),
        {"a.exr", WriteOptions{.bits = 8}, "needs a .png"},
        {"a.png", WriteOptions{.bits = 12}, "8 or 16"}}) {
    const std::string text =
        error_of(ExitCode::usage, [&] { check_writable(file(name), options); });
    EXPECT_TRUE(has(text, part));
    EXPECT_TRUE(has(text, name));
    EXPECT_NE(usage_error([&] { write_image(colours(), file(name), options); }), "no error");
  }
  EXPECT_TRUE(files().empty());
}

TEST(Srgb, IsInvertedInEveryCode) {
  for (int code = 0; code <= 65535; ++code) {
    const double v = code / 65535.0;
    // Rounding only: a few units in the last place of numbers up to 1.
    ASSERT_NEAR(srgb_from_linear(linear_from_srgb(v)), v, 1e-15) << code;
    ASSERT_NEAR(srgb_from_linear(linear_from_srgb(float(v))), float(v), 1e-6f) << code;
  }
}

TEST_F(ImageTest, ReadsPicturesOfOtherPrograms) {
  OIIO::ImageSpec spec(2, 1, 1, OIIO::TypeHalf);
  spec.channelnames = {"Y"};
  write_with_oiio(file("grey.exr"), spec, {0.25f, 2});
  EXPECT_EQ(read_image(file("grey.exr")).layers[0].values,
            (std::vector<float>{0.25f, 0.25f, 0.25f, 1, 2, 2, 2, 1}));

  spec = OIIO::ImageSpec(1, 1, 4, OIIO::TypeFloat);
  spec.channelnames = {"X", "Y", "Z", "W"};
  write_with_oiio(file("vector.exr"), spec, {1, 2, 3, 4});
  EXPECT_TRUE(has(input_error([&] { read_image(file("vector.exr")); }), "but W X Y Z"));

  spec = OIIO::ImageSpec(1, 1, 3, OIIO::TypeFloat);
  write_with_oiio(file("rgb.exr"), spec, {1, 2, 3});
  EXPECT_EQ(read_image(file("rgb.exr")).layers[0].values, (std::vector<float>{1, 2, 3, 1}));

  // The contents, not the name, decide the format.
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

  // Overscan: the data window is larger than the display window.
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

// --- differences of two pictures -----------------------------------------------------------------

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
  a.rgba()[4] = b.rgba()[4] = inf;  // equal in both, but not a finite number
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
  EXPECT_TRUE(std::isnan(compare_images(a, b).rms));  // nothing is known
}

TEST(CompareImages, KeepsSmallDifferencesOfLargeValues) {
  // The squares overflow float, and a float sum of a million of them would lose its last digits.
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
      error_of(ExitCode::input, [] { compare_images(noise(4, 2), noise(2, 4)); });
  EXPECT_TRUE(has(text, "4x2"));
  EXPECT_TRUE(has(text, "2x4"));
}

}  // namespace
}  // namespace psivox
