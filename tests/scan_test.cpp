// NIfTI and NRRD files: values and transforms of every type, byte order and encoding.

#include <cmath>
#include <glm/vec2.hpp>
#include <tuple>
#include <utility>

#include "field/leaf_values.h"
#include "psivox/vdb.h"
#include "scan_made_files.h"
#include "scratch.h"
#include "thrown.h"

namespace psivox::test {
namespace {

#ifndef __SANITIZE_ADDRESS__
/// Before any test starts a thread. AddressSanitizer's allocator does not survive a fork beside
/// OpenImageIO's threads: its locks may be held. It sees more of a reader in this process, too.
const bool started = (start_guarded_reading(), true);
#endif

const glm::dmat4 made_affine{{-2, 0, 0, 0}, {0, 3, 1, 0}, {0, 0, 4, 0}, {20, -5, 0, 1}};

float value_at(const Field& field, const glm::ivec3& v, int c) {
  for (const Leaf& leaf : field.leaves)
    if (const glm::ivec3 at = v - leaf.origin;
        std::min({at.x, at.y, at.z}) >= 0 && std::max({at.x, at.y, at.z}) < 8)
      return OrderedValues(field, leaf)
          .data()[std::size_t(((at.x * 8 + at.y) * 8 + at.z) * field.channels + c)];
  return 0;
}

void expect_made(const VolumeFile& file, const std::string& grid, int channels = 1, int frame = 0,
                 double slope = 1, double intercept = 0) {
  const Field field = file.read(grid, {.role = GridRole::data});
  ASSERT_EQ(field.channels, channels);
  int wrong = 0;
  for (glm::ivec3 v(0); v.z < small.z; ++v.z)
    for (v.y = 0; v.y < small.y; ++v.y)
      for (v.x = 0; v.x < small.x; ++v.x)
        for (int c = 0; c < channels; ++c)
          wrong += value_at(field, v, c) != float(slope * stored_value(v, c, frame) + intercept);
  EXPECT_EQ(wrong, 0);
}

template <typename T>
void expect_nifti_type(int datatype, const std::string& type) {
  for (const bool second : {false, true})
    for (const bool big : {false, true})
      for (const bool packed : {false, true}) {
        std::string bytes = nifti_header(second, big, datatype, dims()) + values_of_type<T>(big);
        if (packed) bytes = gzipped(bytes);
        const VolumeFile file(test::write_bytes("type.nii", bytes));
        EXPECT_EQ(file.names(), std::vector<std::string>{"image"});
        EXPECT_EQ(file.value_type("image"), type);
        expect_made(file, "image");
        EXPECT_EQ(file.read("image").world_from_index, made_affine);
      }
}

TEST(Nifti, EveryTypeAndByteOrderIsRead) {
  expect_nifti_type<std::uint8_t>(2, "uint8");
  expect_nifti_type<std::int16_t>(4, "int16");
  expect_nifti_type<std::int32_t>(8, "int32");
  expect_nifti_type<float>(16, "float32");
  expect_nifti_type<double>(64, "float64");
  expect_nifti_type<std::int8_t>(256, "int8");
  expect_nifti_type<std::uint16_t>(512, "uint16");
  expect_nifti_type<std::uint32_t>(768, "uint32");
  expect_nifti_type<std::int64_t>(1024, "int64");
  expect_nifti_type<std::uint64_t>(1280, "uint64");
}

TEST(Nifti, FramesAreGridsInTheirOrderAndInAnyOther) {
  const VolumeFile file(test::write_bytes(
      "frames.nii.gz", gzipped(nifti_header(false, false, 4, dims({3})) +
                               values_of_type<std::int16_t>(false, 1, false, 3))));
  EXPECT_EQ(file.names(), (std::vector<std::string>{"image[0]", "image[1]", "image[2]"}));
  for (const int frame : {0, 2, 1})
    expect_made(file, "image[" + std::to_string(frame) + "]", 1, frame);
  EXPECT_EQ(file.default_grid(), "image");
  EXPECT_EQ(file.read("image").notices,
            std::vector<std::string>{"the first of 3 frames; --frames 0-2 draws all of them"});
  EXPECT_TRUE(has(input_error([&] { file.read("rgb"); }),
                  "has no grid 'rgb'; it has 'image[0]' 'image[1]' 'image[2]'"));
}

TEST(Nifti, ColoursAndVectorsHaveThreeChannels) {
  expect_made(
      VolumeFile(test::write_bytes("rgb.nii", nifti_header(false, false, 128, dims()) +
                                                  values_of_type<std::uint8_t>(false, 3, true))),
      "rgb", 3);
  for (const bool packed : {false, true}) {
    const std::string bytes =
        nifti_header(false, true, 16, dims({1, 3})) + values_of_type<float>(true, 3);
    expect_made(VolumeFile(test::write_bytes("vectors.nii", packed ? gzipped(bytes) : bytes)),
                "image", 3);
  }
}

TEST(Nifti, SlopeAndInterceptScaleUnlessTheSlopeIs0) {
  for (const float slope : {0.25f, 0.0f}) {
    std::string bytes = nifti_header(false, false, 2, dims());
    put(bytes, 112, slope, false);
    put(bytes, 116, -8.0f, false);
    const VolumeFile file(
        test::write_bytes("slope.nii", bytes + values_of_type<std::uint8_t>(false)));
    expect_made(file, "image", 1, 0, slope == 0 ? 1 : double(slope), slope == 0 ? 0 : -8);
  }
}

/// The transform of a header that was changed.
glm::dmat4 transform_of(const std::function<void(std::string&)>& change) {
  std::string bytes = nifti_header(false, false, 2, dims());
  put<std::int16_t>(bytes, 254, 0, false);  // no sform
  change(bytes);
  return VolumeFile(test::write_bytes("place.nii", bytes + values_of_type<std::uint8_t>(false)))
      .read("image")
      .world_from_index;
}

TEST(Nifti, TheQformComesAfterTheSformAndBeforeTheSizesOfVoxels) {
  const auto sizes = [](std::string& bytes) {
    for (std::size_t i = 0; i < 3; ++i) put(bytes, 80 + 4 * i, float(i + 1), false);
  };
  // nibabel's: x to the left, about the middle
  EXPECT_EQ(transform_of(sizes),
            (glm::dmat4{{-1, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 3, 0}, {5, -8, -13.5, 1}}));
  const glm::dmat4 turned = transform_of([&](std::string& bytes) {
    sizes(bytes);
    put<std::int16_t>(bytes, 252, 1, false);
    put(bytes, 76, -1.0f, false);                   // the third axis the other way
    put(bytes, 264, float(std::sqrt(0.5)), false);  // a quarter about z
    for (std::size_t i = 0; i < 3; ++i) put(bytes, 268 + 4 * i, float(10 * i), false);
  });
  const glm::dmat4 expected{{0, 1, 0, 0}, {-2, 0, 0, 0}, {0, 0, -3, 0}, {0, 10, 20, 1}};
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      EXPECT_NEAR(turned[c][r], expected[c][r], 2 * 1.2e-7);  // the quaternion is a float's
}

TEST(Nifti, AnSformThatIsEmptyDoesNotCount) {
  for (const bool qform : {true, false}) {
    std::string bytes = nifti_header(false, false, 2, dims());  // its code names an sform
    std::fill_n(bytes.begin() + 280, 48, '\0');
    for (std::size_t i = 0; i < 3; ++i) put(bytes, 80 + 4 * i, float(i + 1), false);
    put<std::int16_t>(bytes, 252, qform, false);
    put(bytes, 268, 7.0f, false);
    const Field field =
        VolumeFile(test::write_bytes("empty.nii", bytes + values_of_type<std::uint8_t>(false)))
            .read("image");
    EXPECT_EQ(field.world_from_index[1], glm::dvec4(0, 2, 0, 0));
    EXPECT_EQ(field.world_from_index[3].x, qform ? 7 : 5);
    ASSERT_EQ(field.notices.size(), 1u);
    EXPECT_TRUE(has(field.notices[0], qform ? "by its qform" : "by its pixdim"));
  }
}

TEST(Nifti, APairIsReadByItsHeader) {
  std::string bytes = nifti_header(false, false, 4, dims());
  bytes.replace(344, 3, "ni1");
  put(bytes, 108, 0.0f, false);
  const auto path = test::write_bytes("pair.hdr", bytes.substr(0, 348));
  fs::remove(fs::path(path).replace_extension(".img"));
  EXPECT_TRUE(has(refusal_of(path), "pair.img: no such file"));
  test::write_bytes("pair.img", values_of_type<std::int16_t>(false));
  expect_made(VolumeFile(path), "image");
}

template <typename T>
void expect_nrrd_type(const std::string& type) {
  for (const bool big : {false, true})
    for (const bool packed : {false, true}) {
      const std::string head =
          nrrd(type, std::string("endian: ") + (big ? "big" : "little") +
                         (packed ? "\nencoding: gzip\n\n" : "\nencoding: raw\n\n"));
      const std::string values = values_of_type<T>(big);
      const VolumeFile file(
          test::write_bytes("type.nrrd", head + (packed ? gzipped(values) : values)));
      expect_made(file, "image");
      EXPECT_EQ(file.read("image").world_from_index, made_affine);
      EXPECT_FALSE(file.z_up().empty());
    }
}

TEST(Nrrd, EveryTypeAndByteOrderIsRead) {
  expect_nrrd_type<std::int8_t>("signed char");
  expect_nrrd_type<std::uint8_t>("uchar");
  expect_nrrd_type<std::int16_t>("short");
  expect_nrrd_type<std::uint16_t>("unsigned short int");
  expect_nrrd_type<std::int32_t>("int32_t");
  expect_nrrd_type<std::uint32_t>("uint");
  expect_nrrd_type<std::int64_t>("longlong");
  expect_nrrd_type<std::uint64_t>("uint64");
  expect_nrrd_type<float>("float");
  expect_nrrd_type<double>("double");
}

TEST(Nrrd, TextAndHexAreRead) {
  std::string text, hex;
  for (const char c : values_of_type<std::uint8_t>(false)) {
    text += std::to_string(int(c)) + (text.size() % 3 ? " " : "\n");
    constexpr char digits[] = "0123456789abcdef";
    hex += {digits[c >> 4], digits[c & 15]};
    if (hex.size() % 70 == 0) hex += '\n';
  }
  expect_made(VolumeFile(test::write_bytes("t.nrrd", nrrd("uchar", "encoding: ascii\n\n") + text)),
              "image");
  expect_made(VolumeFile(test::write_bytes("h.nrrd", nrrd("uchar", "encoding: hex\n\n") + hex)),
              "image");
  // skipped bytes are those of the file, not of the values
  const std::string skip = nrrd("uchar", "encoding: hex\nbyte skip: 500\n\n");
  std::erase(hex, '\n');
  expect_made(VolumeFile(test::write_bytes("s.nrrd", skip + std::string(500, '?') + hex)), "image");
}

TEST(Nrrd, ValuesBesideTheHeaderAreReadWithSkips) {
  const std::string values = values_of_type<std::uint8_t>(false);
  test::write_bytes("below/a.raw", "one\ntwo\nxyz" + values);
  const std::string data = "data file: below/a.raw";
  expect_made(VolumeFile(test::write_bytes("a.nhdr", nrrd("uchar",
                                                          "encoding: raw\nline skip: 2\nbyte skip: "
                                                          "3\n" +
                                                              data))),
              "image");
  expect_made(VolumeFile(test::write_bytes(
                  "b.nhdr", nrrd("uchar", "encoding: raw\nbyte skip: -1\n" + data + "\n"))),
              "image");
  test::write_bytes("below/a.gz", "one\n" + gzipped("xyz" + values));
  expect_made(VolumeFile(test::write_bytes("c.nhdr", nrrd("uchar",
                                                          "data file: below/a.gz\nencoding: gz\n"
                                                          "line skip: 1\nbyte skip: 3\n"))),
              "image");
  test::write_bytes("below/b.gz", gzipped("any header" + values));
  expect_made(VolumeFile(test::write_bytes(
                  "d.nhdr", nrrd("uchar", "data file: below/b.gz\nencoding: gz\nbyte skip: -1\n"))),
              "image");
  test::write_bytes("below/c.gz", gzipped(values.substr(1)));
  EXPECT_THROW(
      VolumeFile(test::write_bytes(
          "e.nhdr", nrrd("uchar", "data file: below/c.gz\nencoding: gz\nbyte skip: -1\n"))),
      Error);
}

TEST(Nrrd, AxesBesideSpaceAreColoursOrFrames) {
  const auto with_axes = [](const std::string& sizes, const std::string& kinds) {
    return "NRRD0005\ntype: uint8\ndimension: 4\nsizes: " + sizes + "\nkinds: " + kinds +
           "\nencoding: raw\n\n";
  };
  expect_made(VolumeFile(test::write_bytes(
                  "rgb.nrrd", with_axes("3 11 9 10", "RGB-color domain domain domain") +
                                  values_of_type<std::uint8_t>(false, 3, true))),
              "rgb", 3);
  expect_made(VolumeFile(test::write_bytes("planar.nrrd",
                                           with_axes("11 9 10 3", "domain domain domain 3-vector") +
                                               values_of_type<std::uint8_t>(false, 3))),
              "image", 3);
  // a list of three channels, the fastest axis: frames within a plane
  const VolumeFile tensor(test::write_bytes(
      "list.nrrd", with_axes("3 11 9 10", "2D-symmetric-matrix space space space") +
                       values_of_type<std::uint8_t>(false, 3, true)));
  EXPECT_EQ(tensor.names().size(), 3u);
  EXPECT_FALSE(tensor.metadata().contains("frames"));
  const VolumeFile list(
      test::write_bytes("list.nrrd", with_axes("3 11 9 10", "list space space space") +
                                         values_of_type<std::uint8_t>(false, 3, true)));
  ASSERT_EQ(list.names().size(), 3u);
  EXPECT_TRUE(list.metadata().contains("frames"));
  const Field second = list.read("image[1]");
  EXPECT_EQ(value_at(second, {5, 4, 9}, 0), float(stored_value({5, 4, 9}, 1, 0)));
  // one slice, of the same values: the channels lie a plane apart
  const Field slice =
      VolumeFile(
          test::write_bytes("slice.nrrd", with_axes("11 90 1 3", "space space space vector") +
                                              values_of_type<std::uint8_t>(false, 3)))
          .read("image", {.role = GridRole::data});
  for (int c = 0; c < 3; ++c)
    EXPECT_EQ(value_at(slice, {5, 9 * 4 + 7, 0}, c), float(stored_value({5, 7, 4}, c, 0)));
  // kinds by their other names; a colour that is not red, green and blue is a list
  for (const auto& [kind, grids] : {std::pair("RGB", 1u), std::pair("HSV-color", 3u)}) {
    const VolumeFile file(test::write_bytes(
        "kind.nrrd", with_axes("3 11 9 10", kind + std::string(" space space space")) +
                         values_of_type<std::uint8_t>(false, 3, true)));
    EXPECT_EQ(file.names().size(), grids) << kind;
    EXPECT_EQ(file.names().at(0), grids == 1 ? "rgb" : "image[0]");
  }
}

TEST(Nrrd, AFirstAxisOfBytesWithoutAKindHasColours) {
  for (const auto& [type, size, name] :
       {std::tuple("uint8", 3, "rgb"), {"uint8", 4, "rgb"}, {"int8", 3, "image"}}) {
    const VolumeFile file(test::write_bytes(
        "bare.nrrd",
        "NRRD0005\ntype: " + std::string(type) + "\ndimension: 4\nsizes: " + std::to_string(size) +
            " 11 9 10\nencoding: raw\n\n" + values_of_type<std::uint8_t>(false, size, true)));
    expect_made(file, name, 3);
  }
}

TEST(Nrrd, ATimeAxisHasFrames) {
  const std::string fields[] = {
      "space: left-posterior-superior-time\nkinds: domain domain domain domain\n"
      "space directions: (1,0,0,0) (0,2,0,0) (0,0,3,0) (0,0,0,0.5)\nspace origin: (4,5,6,0)\n",
      "space: LPS\nkinds: domain domain domain time\n"
      "space directions: (1,0,0) (0,2,0) (0,0,3) (0,0,0.5)\nspace origin: (4,5,6)\n",
      "space: LPS\nspace directions: (1,0,0) (0,2,0) (0,0,3) (nan,nan,nan)\n"
      "space origin: (4,5,6)\n"};
  for (const std::string& field : fields) {
    const VolumeFile file(test::write_bytes(
        "time.nrrd", "NRRD0005\ntype: uint8\ndimension: 4\nsizes: 11 9 10 2\nencoding: raw\n" +
                         field + "\n" + values_of_type<std::uint8_t>(false, 1, false, 2)));
    ASSERT_EQ(file.names().size(), 2u) << field;
    expect_made(file, "image[1]", 1, 1);
    EXPECT_EQ(file.read("image[1]").world_from_index,
              (glm::dmat4{{-1, 0, 0, 0}, {0, -2, 0, 0}, {0, 0, 3, 0}, {-4, -5, 6, 1}}));
  }
}

TEST(Nrrd, ASpaceHasSeveralNames) {
  const std::pair<const char*, glm::dvec2> all[] = {{"left-posterior-superior", {-1, -1}},
                                                    {"left posterior superior", {-1, -1}},
                                                    {"LPST", {-1, -1}},
                                                    {"LeftAnteriorSuperior", {-1, 1}},
                                                    {"RAS", {1, 1}},
                                                    {"scanner-xyz-time", {1, 1}},
                                                    {"3D-left-handed", {1, 1}}};
  for (const auto& [name, signs] : all) {
    const VolumeFile file(test::write_bytes(
        "space.nrrd",
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 11 9 10\nencoding: raw\nspace: " +
            std::string(name) + "\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n\n" +
            values_of_type<std::uint8_t>(false)));
    const glm::dmat4 expected{{signs.x, 0, 0, 0}, {0, signs.y, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    EXPECT_EQ(file.read("image").world_from_index, expected) << name;
    EXPECT_EQ(file.z_up().empty(), std::string(name).starts_with("3D")) << name;
  }
}

TEST(Nrrd, WithoutASpaceItHasItsSpacings) {
  const std::string head = "NRRD0001\ntype: uint8\ndimension: 3\nsizes: 11 9 10\nencoding: raw\n";
  const VolumeFile file(
      test::write_bytes("s.nrrd", head +
                                      "spacings: 1 2 nan\naxis mins: 5 nan 0\n"
                                      "centers: cell node ???\naxis maxs: 9 9 30\n\n" +
                                      values_of_type<std::uint8_t>(false)));
  EXPECT_TRUE(file.z_up().empty());
  EXPECT_EQ(file.read("image").world_from_index,
            (glm::dmat4{{1, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 3, 0}, {5.5, 0, 1.5, 1}}));
  // directions of which none is one say nothing either
  const VolumeFile undirected(test::write_bytes(
      "u.nrrd", head +
                    "space: RAS\nspace directions: none none none\nkinds: space space space\n"
                    "spacings: 2 2 5\nspace origin: (10,12,100)\n\n" +
                    values_of_type<std::uint8_t>(false)));
  EXPECT_EQ(undirected.read("image").world_from_index,
            (glm::dmat4{{2, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 5, 0}, {10, 12, 100, 1}}));
}

}  // namespace
}  // namespace psivox::test
