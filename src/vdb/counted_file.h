#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <utility>

#include "psivox/progress.h"

namespace psivox::vdb {

/// A file to read from that reports the fraction read of an expected number of bytes.
class CountedFile final : public std::filebuf {
 public:
  CountedFile(const std::filesystem::path& path, Progress progress)
      : progress_(std::move(progress)) {
    open(path, std::ios::in | std::ios::binary);
  }

  /// Sets the number of bytes expected from now on.
  void expect(std::int64_t bytes) {
    expected_ = std::max<std::int64_t>(bytes, 1);
    read_ = told_ = 0;
  }

 protected:
  std::streamsize xsgetn(char* to, std::streamsize count) override {
    const std::streamsize got = std::filebuf::xsgetn(to, count);
    read_ += got;
    if (progress_ && read_ - told_ >= interval) {
      told_ = read_;
      progress_(std::min(1.0, static_cast<double>(read_) / static_cast<double>(expected_)));
    }
    return got;
  }

 private:
  static constexpr std::int64_t interval = 1 << 15;  // [bytes]

  Progress progress_;
  std::int64_t expected_ = 1, read_ = 0, told_ = 0;
};

}  // namespace psivox::vdb
