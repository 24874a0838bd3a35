#include "psivox/text_file.h"
#include "psivox/text.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <system_error>

#include "psivox/error.h"
#include "psivox/hidden_file.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, int error) {
  throw Error(ExitCode::output, "cannot write " + in_quotes(path) + ": " + std::strerror(error));
}

fs::path directory_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// Writes to a file, null if it could not be opened, and closes it.
void write_whole(const std::string& path, std::FILE* file, const std::string& text) {
  if (!file) fail(path, errno);
  const bool complete = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  int error = complete ? 0 : errno;
  if (std::fclose(file) != 0 && !error) error = errno;
  if (error) fail(path, error);
}

bool is_special(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status);
}

}  // namespace

std::string read_text(const std::string& path, const std::string& what) {
  const auto refuse = [&](const char* why) {
    throw Error(ExitCode::input, "cannot read " + what + " " + in_quotes(path) + ": " + why);
  };
  if (fs::is_directory(path)) refuse(std::strerror(EISDIR));
  std::ifstream in(path, std::ios::binary);
  if (!in) refuse(std::strerror(errno));
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) refuse(std::strerror(errno));
  return text;
}

void check_text_writable(const std::string& path) {
  if (path == "-") return;
  if (fs::is_directory(path)) fail(path, EISDIR);
  const std::string place = is_special(path) ? path : directory_of(path).string();
  if (access(place.c_str(), W_OK) != 0) fail(path, errno);
}

void write_text(const std::string& path, const std::string& text) {
  if (path == "-") {
    std::cout << text;  // main checks whether it was written
    return;
  }
  if (is_special(path)) return write_whole(path, std::fopen(path.c_str(), "wb"), text);
  std::error_code unresolved;
  const fs::path target = fs::weakly_canonical(path, unresolved);  // keeps a symbolic link a link
  try {
    HiddenFile file(unresolved ? fs::path(path) : target);
    write_whole(path, fdopen(file.open(), "wb"), text);
    file.show();
  } catch (const std::system_error& failure) {
    fail(path, failure.code().value());
  }
}

}  // namespace psivox
