#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "scan/byte_stream.h"
#include "scan/header.h"

namespace psivox::scan {

/// The values of a scan in the file's order, as floats.
class ValueStream {
 public:
  /// Begins before the first value. Header and file must live as long.
  ValueStream(const Header& header, FileBlocks& file);

  /// Number of the next value.
  std::int64_t position() const { return position_; }

  /// These throw Error(input) if the file ends before, or holds no numbers.
  void pass_over(std::int64_t values);
  void read(std::span<float> to);

 private:
  double next_number();                          ///< of a text
  void read_bytes(char* to, std::int64_t size);  ///< decoded; of another encoding than text

  const Header& header_;
  ByteStream bytes_;
  std::string buffer_;
  std::int64_t position_ = 0;
};

}  // namespace psivox::scan
