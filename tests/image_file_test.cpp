// Damaged files, targets that cannot be written, and the files left behind.
#include "image_cases.h"
#include "scratch.h"
#include "thrown.h"

namespace psivox {
namespace {

TEST_F(ImageTest, ReadingNamesTheFileAndTheReason) {
  const auto read_text = [&](const std::string& name) {
    const fs::path path = name.empty() ? directory_ : file(name);
    const std::string text = error_of(ExitCode::input, [&] { read_image(path); });
    EXPECT_TRUE(has(text, "cannot read '" + path.string() + "': "));
    return text;
  };
  EXPECT_TRUE(has(read_text("absent.exr"), "no such file"));
  EXPECT_TRUE(has(read_text(""), "directory"));
  test::write_bytes("empty.exr", "");
  EXPECT_TRUE(has(read_text("empty.exr"), "no EXR, PNG, TIFF"));
  test::write_bytes("text.png", "P6 1 1 255 abc");
  EXPECT_TRUE(has(read_text("text.png"), "no EXR, PNG, TIFF"));
  EXPECT_NE(input_error([&] { read_metadata(file("text.png"), "psivox:scene"); }), "no error");

  OIIO::ImageSpec spec(1, 1, 1, OIIO::TypeFloat);
  spec.channelnames = {"depth"};
  write_with_oiio(file("depth.exr"), spec, {1});
  EXPECT_TRUE(has(read_text("depth.exr"), "but depth"));
}

TEST_F(ImageTest, AFileCutShortIsAnErrorAndPrintsNothingItself) {
  const Image image = noise(48, 40, {"depth"});
  testing::internal::CaptureStderr();
  for (const char* name : every_format) {
    write_image(image, file(name));
    const std::string whole = test::file_bytes(file(name));
    for (const std::size_t size : {std::size_t{8}, std::size_t{30}, std::size_t{200},
                                   std::size_t{380}, whole.size() / 2, whole.size() - 1}) {
      test::write_bytes("cut", whole.substr(0, size));
      const std::string text = error_of(ExitCode::input, [&] { read_image(file("cut")); });
      EXPECT_TRUE(has(text, "cut'")) << name << " of " << size;
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(ImageTest, AnAttributeThatIsLongerThanItsExrIsNotAllocated) {
  Image image = noise(4, 4);
  image.metadata["psivox:scene"] = "{}";
  write_image(image, file("a.exr"));
  std::string bytes = test::file_bytes(file("a.exr"));
  const std::string before("psivox:scene\0string\0", 20);
  ASSERT_TRUE(has(bytes, before));
  for (const std::int32_t length : {1 << 30, -1}) {
    std::memcpy(bytes.data() + bytes.find(before) + before.size(), &length, sizeof length);
    test::write_bytes("long.exr", bytes);
    const std::string text = error_of(ExitCode::input, [&] { read_image(file("long.exr")); });
    EXPECT_TRUE(has(text, "an attribute of type 'string' is longer than the file"));
  }
}

TEST_F(ImageTest, AnAttributeOfAnotherLengthThanItsValueIsAnError) {
  write_image(noise(4, 4), file("a.exr"));
  const std::string bytes = test::file_bytes(file("a.exr"));
  const std::map<std::string, std::string> types = {{"channels", "chlist"},
                                                    {"compression", "compression"},
                                                    {"dataWindow", "box2i"},
                                                    {"pixelAspectRatio", "float"}};
  for (const auto& [name, type] : types) {
    std::string wrong = bytes;
    const std::string start = name + '\0' + type + '\0';
    ASSERT_TRUE(has(wrong, start));
    const std::size_t length = wrong.find(start) + start.size();
    const auto bytes_of_value = std::size_t(std::uint8_t(wrong[length]));
    ++wrong[length];
    wrong.insert(length + 4 + bytes_of_value, 1, 'x');
    test::write_bytes("wrong.exr", wrong);
    const std::string text = error_of(ExitCode::input, [&] { read_image(file("wrong.exr")); });
    EXPECT_TRUE(has(text, "an attribute of type '" + type + "' has a wrong length"));
  }
}

TEST_F(ImageTest, AShortExrOfManyPixelsIsRefused) {
  write_image(noise(4, 4), file("a.exr"));
  std::string bytes = test::file_bytes(file("a.exr"));
  const std::int32_t window[] = {0, 0, 3999999, 63};
  for (const std::string name : {"dataWindow", "displayWindow"}) {
    const std::string start = name + '\0' + "box2i" + '\0';
    ASSERT_TRUE(has(bytes, start));
    std::memcpy(bytes.data() + bytes.find(start) + start.size() + 4, window, sizeof window);
  }
  test::write_bytes("short.exr", bytes);
  const std::string text = error_of(ExitCode::input, [&] { read_image(file("short.exr")); });
  // OpenImageIO 3.1 refuses it by a limit of its own, before psivox sees it
  EXPECT_TRUE(text.find("4000000x64 pixels stored in so short a file") != text.npos ||
              text.find("limits:resolution") != text.npos)
      << text;
}

TEST_F(ImageTest, EveryDamagedByteIsAnErrorOrAPictureAndPrintsNothing) {
  testing::internal::CaptureStderr();
  for (const char* name : every_format) {
    write_image(noise(4, 4), file(name));
    const std::string whole = test::file_bytes(file(name));
    const std::size_t data_window = whole.find("dataWindow") + 21;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      // Millions of columns are legal in an EXR, and zip needs no bytes for them.
      if (name == std::string("a.exr") && i >= data_window && i < data_window + 16) continue;
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ 1);
      test::write_bytes("damaged", damaged);
      try {
        read_image(file("damaged"));
        EXPECT_NE(name, std::string("a.png")) << "has a sum over every byte, " << i;
      } catch (const Error& error) {
        EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(ExitCode::input))
            << error.what();
      }
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(ImageTest, AnUnknownExtensionIsAUsageErrorThatNamesTheKnown) {
  for (const char* name : {"a.bmp", "a", "a.exr.bak", ".exr"}) {
    for (const auto& call : {std::function([&] { check_writable(file(name)); }),
                             std::function([&] { write_image(noise(1, 1), file(name)); })}) {
      const std::string text = error_of(ExitCode::usage, call);
      EXPECT_TRUE(has(text, "use .exr, .png, .tif, .tiff, .jpg, .jpeg, .hdr or .webp"));
    }
  }
  EXPECT_TRUE(files().empty());
  for (const char* name : {"a.EXR", "a.tiff", "a.Jpeg"}) {
    EXPECT_TRUE(has_picture_extension(name));
    write_image(noise(1, 1), file(name));
    EXPECT_EQ(read_image(file(name)).width, 1);
  }
  EXPECT_FALSE(has_picture_extension("a.json"));
}

TEST_F(ImageTest, AnUnwritableTargetIsFoundBeforeAnyWork) {
  fs::create_directory(file("directory.exr"));
  ASSERT_EQ(mkfifo(file("pipe.exr").c_str(), 0600), 0);
  Names unwritable = {file("absent/a.exr"), file("directory.exr"), file("pipe.exr"),
                      "/proc/psivox.exr"};
  if (geteuid() != 0) {  // root may write everywhere
    test::write_bytes("protected.exr", "old");
    fs::permissions(file("protected.exr"), fs::perms::owner_read);
    fs::create_directory(file("sealed"));
    fs::permissions(file("sealed"), fs::perms::owner_read | fs::perms::owner_exec);
    unwritable.insert(unwritable.end(), {file("protected.exr"), file("sealed/a.exr")});
  }
  const Names before = files();
  for (const std::string& path : unwritable) {
    const std::string checked = error_of(ExitCode::output, [&] { check_writable(path); });
    EXPECT_TRUE(has(checked, path));
    EXPECT_EQ(error_of(ExitCode::output, [&] { write_image(noise(1, 1), path); }), checked);
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
  test::write_bytes("store/real.exr", "old");
  fs::create_symlink("store/real.exr", file("link.exr"));
  write_image(noise(3, 1), file("link.exr"));
  EXPECT_TRUE(fs::is_symlink(file("link.exr")));
  EXPECT_EQ(read_image(file("store/real.exr")).width, 3);
  fs::create_symlink("store/new.exr", file("to_new.exr"));  // whose file is not there yet
  write_image(noise(4, 1), file("to_new.exr"));
  EXPECT_TRUE(fs::is_symlink(file("to_new.exr")));
  EXPECT_EQ(read_image(file("store/new.exr")).width, 4);
}

TEST_F(ImageTest, LightBeyondTheFilesNumbersIsSaid) {
  Image image = noise(2, 1);
  const auto told = [&](const char* name, const WriteOptions& options) {
    const std::string notice = write_image(image, file(name), options);
    EXPECT_TRUE(notice.empty() || notice.find("1 of 2 pixels") != std::string::npos) << notice;
    return !notice.empty();
  };
  image.rgba()[0] = 65504;
  EXPECT_FALSE(told("a.exr", {.half = true}));
  image.rgba()[0] = 1e6f;
  EXPECT_TRUE(told("a.exr", {.half = true}));
  EXPECT_EQ(read_image(file("a.exr")).rgba()[0], 65504) << "infinity";
  EXPECT_FALSE(told("a.exr", {}));
  image.rgba()[0] = 2e38f;
  EXPECT_TRUE(told("a.hdr", {}));
  EXPECT_FALSE(told("a.exr", {}));
  image.rgba()[0] = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(told("a.hdr", {}));
  EXPECT_FALSE(told("a.exr", {})) << "which holds it";
  EXPECT_FALSE(told("a.exr", {.half = true}));
}

TEST_F(ImageTest, AFullDiskIsAnErrorAndLeavesTheOldFile) {
  // A limit on file size fails a write as a full disk does: first a short write, then an errno.
  const Image image = noise(64, 64, {"depth"});
  const auto previous_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit previous{};
  getrlimit(RLIMIT_FSIZE, &previous);
  for (const char* name : every_format) {
    write_image(image, file("whole").replace_extension(fs::path(name).extension()));
    const auto size = fs::file_size(file("whole").replace_extension(fs::path(name).extension()));
    test::write_bytes(name, "old");
    // From the first byte to the last, which leaves the buffer only when the file is closed.
    for (const auto limit : {std::uintmax_t{0}, std::uintmax_t{100}, size / 2, size - 1}) {
      rlimit tight = previous;
      tight.rlim_cur = limit;
      setrlimit(RLIMIT_FSIZE, &tight);
      const std::string text = error_of(ExitCode::output, [&] { write_image(image, file(name)); });
      setrlimit(RLIMIT_FSIZE, &previous);
      EXPECT_TRUE(has(text, std::strerror(EFBIG))) << name << limit;
      EXPECT_EQ(test::file_bytes(file(name)), "old");
    }
  }
  std::signal(SIGXFSZ, previous_handler);
  EXPECT_EQ(files().size(), 2 * std::size(every_format));
}

TEST_F(ImageTest, AMalformedImageIsRefused) {
  Image image = noise(2, 2, {"depth"});
  image.layers[1].values.pop_back();
  EXPECT_TRUE(
      has(error_of(ExitCode::failure, [&] { write_image(image, file("a.exr")); }), "depth"));
  image = noise(2, 2, {"R"});
  for (const Image& wrong : {image, Image{}})
    EXPECT_NE(error_of(ExitCode::failure, [&] { write_image(wrong, file("a.exr")); }), "no error");
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

}  // namespace
}  // namespace psivox
