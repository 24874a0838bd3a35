// The formats that OpenImageIO writes: TIFF, JPEG, HDR and WebP.
#include "image_cases.h"
#include "thrown.h"

namespace psivox {
namespace {

/// The light of the brightest channel of a pixel.
float brightest(const Image& image, std::size_t pixel) {
  const float* rgba = &image.rgba()[4 * pixel];
  return std::max({rgba[0], rgba[1], rgba[2]});
}

/// With alpha 1 everywhere.
Image over_black(Image image) {
  for (std::size_t i = 3; i < image.rgba().size(); i += 4) image.rgba()[i] = 1;
  return image;
}

/// Blocks of 16 x 16 pixels, a colour each.
Image blocks() {
  const Image colour = over_black(colours());
  Image image = picture(256, 256, std::vector<float>(4 * 256 * 256));
  for (std::size_t y = 0; y < 256; ++y)
    for (std::size_t x = 0; x < 4 * 256; ++x)
      image.rgba()[4 * 256 * y + x] = colour.rgba()[4 * (16 * (y / 16) + x / 64) + x % 4];
  return image;
}

TEST_F(ImageTest, TiffKeepsEveryBitOfThePicture) {
  Image image = noise(37, 300, {"depth"});
  const std::vector<float> special = {nan,     inf,    -inf,  -0.0f, 1e-42f, -1.5f,
                                      3.4e38f, 1e-38f, 70000, 0,     0,      0};
  std::copy(special.begin(), special.end(), image.rgba().begin());
  EXPECT_EQ(write_image(image, file("a.tif")), "");
  const Image back = read_image(file("a.tif"));
  ASSERT_EQ(back.layers.size(), 1u);
  EXPECT_EQ(back.width, 37);
  EXPECT_EQ(bits(back.layers[0].values), bits(image.layers[0].values));
}

TEST_F(ImageTest, TiffOfCodesIsThePngsPixels) {
  for (const int bits : {8, 16}) {
    SCOPED_TRACE(bits);
    EXPECT_EQ(write_image(colours(), file("a.tif"), {.bits = bits}), "");
    const Image back = read_image(file("a.tif"));
    EXPECT_LE(largest_difference(back, colours()), srgb_error(bits));
    write_image(colours(), file("a.png"), {.bits = bits});
    // The same codes, made floats by OpenImageIO or libpng: a rounding of the code, which the
    // decoding's slope doubles, and two after it, half a unit in the last place of 1 each.
    EXPECT_LE(largest_difference(back, read_image(file("a.png"))), 2 * 4 * 0x1p-24);
  }
  write_image(colours(), file("a.tif"), {.bits = 8});
  write_image(colours(), file("a.png"));
  EXPECT_EQ(stored_bytes(file("a.tif")), stored_bytes(file("a.png")));
}

TEST_F(ImageTest, JpegIsThePictureOverBlack) {
  Image image = blocks();
  const double quarter = 0.25;  // of the light: alpha is not what darkens a picture over black
  for (std::size_t i = 3; i < image.rgba().size(); i += 4) image.rgba()[i] = float(quarter);
  write_image(image, file("a.jpg"));
  // A block of one colour is one coefficient, 8 times its value, that quality 95 stores in steps
  // of 2: an eighth of a code. Y, Cb and Cr are rounded to half a code before, R G B after;
  // B = Y + 1.772 Cb weighs most.
  const double codes = (0.5 + 0.125) * (1 + 1.772) + 0.5;
  EXPECT_LE(largest_difference(read_image(file("a.jpg")), over_black(image)),
            (codes + 0.5) / 255 * 2.4 / 1.055);
}

TEST_F(ImageTest, HdrHoldsLightOfAnyBrightnessOverBlack) {
  Image image = noise(64, 40);
  for (std::size_t i = 0; i < image.rgba().size(); ++i)
    image.rgba()[i] *= i % 4 == 3 ? 1 : std::exp2(static_cast<float>(i % 61) - 30);
  write_image(image, file("a.hdr"));
  const Image back = read_image(file("a.hdr"));
  for (std::size_t i = 0; i < image.rgba().size(); ++i) {
    // Mantissas of 8 bits, which are rounded, share the brightest channel's exponent.
    if (i % 4 == 3)
      EXPECT_EQ(back.rgba()[i], 1);
    else
      EXPECT_NEAR(back.rgba()[i], image.rgba()[i], brightest(image, i / 4) * 0x1p-8f) << i;
  }
}

TEST_F(ImageTest, HdrReplacesWhatRgbeCannotHold) {
  write_image(picture(2, 1, {-1, 0.5f, nan, 1, inf, 0, -inf, 1}), file("a.hdr"));
  const Image back = read_image(file("a.hdr"));
  EXPECT_EQ(std::vector<float>(back.rgba().begin(), back.rgba().end()),
            (std::vector<float>{0, 0.5f, 0, 1, 0x1p126f, 0, 0, 1}));
}

TEST_F(ImageTest, WebpIsThePictureOverBlack) {
  const Image image = blocks();
  write_image(image, file("a.webp"));
  const Image back = read_image(file("a.webp"));
  const auto code = [](const Image& of, std::size_t i) {
    return 255.0 * double{srgb_from_linear(of.rgba()[i])};
  };
  // Lossy, even at quality 100: Y, U and V are whole numbers, U and V of 2x2 pixels. In the middle
  // of a block of one colour no other colour has a part in it. B = 1.164 Y + 2.018 U weighs most:
  // half a unit of each, a quarter from the transform's steps, half a code before and after.
  const double codes = (0.5 + 0.25) * (1.164 + 2.018) + 1;
  for (std::size_t y = 8; y < 256; y += 16)
    for (std::size_t i = 4 * (256 * y + 8); i < 4 * 256 * (y + 1); i += 4 * 16)
      for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(code(back, i + c), code(image, i + c), codes);
}

TEST_F(ImageTest, WhatAFormatCannotHoldIsSaid) {
  const auto lost = [&](const Image& image, const char* name, const WriteOptions& options = {}) {
    return write_image(image, file(name), options);
  };
  // 3 pixels: opaque; half covered; light without opacity
  const Image image = picture(3, 1, {2, 1, 0, 1, 0.25f, 0.5f, 0, 0.5f, 0.1f, 0, 0, 0});
  for (const char* name : {"a.exr", "a.tif"}) EXPECT_EQ(lost(image, name), "");
  for (const char* name : {"a.jpg", "a.hdr", "a.webp"}) {
    const std::string text = lost(image, name);
    EXPECT_TRUE(has(text, "no alpha: 2 of 3 pixels"));
    EXPECT_TRUE(has(text, name));
    EXPECT_EQ(lost(over_black(image), name), "");
  }
  for (const std::string& text : {lost(image, "a.png"), lost(image, "a.tif", {.bits = 16})}) {
    // red 0.1 of 1 + 1 + 0.25 + 0.5 + 0.1
    EXPECT_TRUE(has(text, "loses 3.5 % of the picture's light: 1 of 3 pixels"));
    EXPECT_TRUE(has(text, "give --background R,G,B"));
  }
  EXPECT_EQ(lost(over_black(image), "a.png"), "");
}

TEST_F(ImageTest, TiffAndJpegKeepTheScene) {
  Image image = colours();
  image.metadata = {{"psivox:scene", "{\n  \"grid\": \"Dichte \xc3\xa4\",\t\"a\\\"b\"\r\n} "},
                    {"psivox:renderer", "llvmpipe (LLVM 15.0.6, 256 bits)"},
                    {"psivox:version", "1.2.3"}};
  for (const char* name : {"a.tif", "a.jpg"}) {
    SCOPED_TRACE(name);
    write_image(image, file(name));
    EXPECT_EQ(read_image(file(name)).metadata, image.metadata);
    EXPECT_EQ(read_metadata(file(name), "psivox:scene"), image.metadata.at("psivox:scene"));
    EXPECT_EQ(read_metadata(file(name), "psivox:absent"), "");
  }
  // Too long for a JPEG's segment: left out, and the picture is whole.
  image.metadata["psivox:scene"] = long_json();
  for (const char* name : {"a.tif", "a.jpg"}) {
    write_image(image, file(name));
    EXPECT_EQ(read_metadata(file(name), "psivox:scene"), "");
    EXPECT_EQ(read_metadata(file(name), "psivox:version"), "1.2.3");
  }
  for (const char* name : {"a.hdr", "a.webp"}) {
    write_image(image, file(name));
    EXPECT_EQ(read_metadata(file(name), "psivox:scene"), "");
  }
}

TEST_F(ImageTest, AnEncodersLimitIsAnErrorBeforeAnyWork) {
  for (const auto& [name, side] : {std::pair("a.webp", 16383), {"a.jpg", 65500}}) {
    check_writable(file(name), {}, side, 1);
    const auto is_refused = [&](const std::function<void()>& call) {
      const std::string text = error_of(ExitCode::output, call);
      EXPECT_TRUE(has(text, std::to_string(side) + " pixels"));
    };
    is_refused([&] { check_writable(file(name), {}, 1, side + 1); });
    is_refused([&] { write_image(noise(side + 1, 1), file(name)); });
    EXPECT_TRUE(files().empty());
    write_image(noise(side, 1), file(name));
    EXPECT_EQ(read_image(file(name)).width, side);
    fs::remove(file(name));
  }
}

TEST_F(ImageTest, ReadsTheseFormatsOfOtherPrograms) {
  OIIO::ImageSpec spec(1, 1, 2, OIIO::TypeUInt16);
  spec.channelnames = {"Y", "A"};
  spec.alpha_channel = 1;
  spec.attribute("oiio:UnassociatedAlpha", 1);
  write_with_oiio(file("grey.tif"), spec, {0.5f, 0.25f});
  const float grey = 0.25f * 0.214041f;
  EXPECT_NEAR(read_image(file("grey.tif")).rgba()[1], grey, 1e-5f);  // 1/65535 and rounding
  EXPECT_NEAR(read_image(file("grey.tif")).rgba()[3], 0.25f, 1e-5f);

  // Codes that were multiplied by alpha; 16 bits make the division exact enough.
  spec = OIIO::ImageSpec(1, 1, 4, OIIO::TypeUInt16);
  write_with_oiio(file("associated.tif"), spec, {0.125f, 0.25f, 0, 0.25f});
  EXPECT_NEAR(read_image(file("associated.tif")).rgba()[0], grey, 1e-5f);
  EXPECT_NEAR(read_image(file("associated.tif")).rgba()[1], 0.25f, 1e-5f);

  spec = OIIO::ImageSpec(1, 1, 3, OIIO::TypeFloat);
  spec.attribute("Software", "another");
  spec.attribute("ImageDescription", "a view");
  write_with_oiio(file("float.tif"), spec, {-1, 2, 3});
  EXPECT_EQ(read_image(file("float.tif")).layers[0].values, (std::vector<float>{-1, 2, 3, 1}));
  EXPECT_EQ(read_metadata(file("float.tif"), "psivox:scene"), "");
  EXPECT_EQ(read_metadata(file("float.tif"), "ImageDescription"), "a view");

  spec = OIIO::ImageSpec(8, 8, 1, OIIO::TypeUInt8);
  write_with_oiio(file("grey.jpg"), spec, std::vector<float>(64, 0.5f));
  EXPECT_NEAR(read_image(file("grey.jpg")).rgba()[2], 0.214041f, 2.5 / 255);  // a code off
}

}  // namespace
}  // namespace psivox
