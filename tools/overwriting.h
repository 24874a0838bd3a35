#pragma once

#include <span>
#include <string>

namespace psivox {

/// A file that an option writes. An empty path is none.
struct WrittenFile {
  const char* option;
  std::string path;
};

/// Throws Error(usage) if one of the files is also read, by whatever name or link, or written by
/// two options. Empty names and `-` are no files.
void check_overwriting(std::span<const WrittenFile> written, std::span<const std::string> read);

}  // namespace psivox
