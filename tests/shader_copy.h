#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "march_cases.h"
#include "scratch.h"

namespace psivox {

namespace fs = std::filesystem;

/// A test with a copy of shaders/, to which PSIVOX_SHADER_DIR points during the test.
class ShaderTest : public GpuTest {
 protected:
  void SetUp() override {
    folder_ = test::scratch_dir() / "shaders";
    fs::remove_all(folder_);
    fs::copy(PSIVOX_SHADERS, folder_, fs::copy_options::recursive);
    setenv("PSIVOX_SHADER_DIR", folder_.c_str(), 1);
    GpuTest::SetUp();
  }
  void TearDown() override {
    unsetenv("PSIVOX_SHADER_DIR");
    fs::remove_all(folder_);
  }

  /// Replaces `from`, which must be present, in a file of the copy; returns its line number.
  int edit(const std::string& name, const std::string& from, const std::string& to) {
    std::string text = test::file_bytes(folder_ / name);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << name << " has no '" << from << "'";
    if (at == std::string::npos) return 0;
    const auto line = 1 + std::count(text.begin(), text.begin() + std::ptrdiff_t(at), '\n');
    text.replace(at, from.size(), to);
    fs::permissions(folder_ / name, fs::perms::owner_write, fs::perm_options::add);
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return int(line);
  }

  fs::path folder_;
};

}  // namespace psivox
