#include "output_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "format.h"

namespace fs = std::filesystem;

namespace psivox::image_io {
namespace {

fs::path directory_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

void check_target(const fs::path& named, const fs::path& target) {
  std::error_code ignored;
  if (fs::is_directory(target, ignored)) throw write_error(named, "it is a directory");
  const bool exists = fs::exists(target, ignored);
  if (exists && !fs::is_regular_file(target, ignored)) {
    throw write_error(named, "it is not a regular file");
  }
  // A rename would replace a read-only file; who protected it does not expect that.
  if (exists && ::access(target.c_str(), W_OK) != 0) throw write_error(named, std::strerror(errno));
  const fs::path directory = directory_of(target);
  if (!fs::is_directory(directory, ignored)) {
    throw write_error(named, "there is no directory '" + directory.string() + "'");
  }
}

}  // namespace

OutputFile::OutputFile(const fs::path& target) : named_(target), target_(target) {
  std::error_code ignored;
  if (is_standard_output(target)) {
    // Encoders seek, and a pipe takes all or nothing: the bytes go there when they are complete.
    if (::isatty(STDOUT_FILENO) == 1)
      throw write_error(named_, "the standard output is a terminal; redirect it");
    target_.clear();
    file_ = std::tmpfile();
    if (file_ == nullptr) throw write_error(named_, std::strerror(errno));
    return;
  }
  // the links stay, and the last one's file need not exist
  for (int links = 0; links < 40 && fs::is_symlink(target_, ignored); ++links)
    target_ = directory_of(target_) / fs::read_symlink(target_, ignored);
  check_target(named_, target_);

  try {
    hidden_.emplace(target_);
    file_ = fdopen(hidden_->open(), "wb");
  } catch (const std::system_error& failure) {
    throw write_error(named_, "no file can be created in '" + directory_of(target_).string() +
                                  "': " + failure.code().message());
  }
  if (file_ == nullptr) throw write_error(named_, std::strerror(errno));
}

OutputFile::~OutputFile() {
  if (file_ != nullptr) std::fclose(file_);
}

void OutputFile::remember_failure() {
  if (failure_ == 0) failure_ = errno != 0 ? errno : EIO;
}

bool OutputFile::seek(std::int64_t offset) {
  if (fseeko(file_, offset, SEEK_SET) == 0) return true;
  remember_failure();
  return false;
}

std::size_t OutputFile::write(std::string_view bytes) {
  const std::size_t written = std::fwrite(bytes.data(), 1, bytes.size(), file_);
  if (written != bytes.size()) remember_failure();
  return written;
}

void OutputFile::copy_to_standard_output() {
  std::rewind(file_);
  char bytes[1 << 16];
  for (std::size_t count = 0; (count = std::fread(bytes, 1, sizeof bytes, file_)) > 0;)
    if (std::fwrite(bytes, 1, count, stdout) != count) return remember_failure();
  if (std::fflush(stdout) != 0) remember_failure();
}

void OutputFile::commit(bool library_succeeded, const std::string& library_says) {
  if (target_.empty() && failure_ == 0 && library_succeeded) copy_to_standard_output();
  if (std::fclose(file_) != 0) remember_failure();
  file_ = nullptr;
  if (failure_ != 0) throw write_error(named_, std::strerror(failure_));
  if (!library_succeeded) {
    throw write_error(named_, library_says.empty() ? "the encoder gave no reason" : library_says);
  }
  if (target_.empty()) return;
  try {
    hidden_->show();
  } catch (const std::system_error& failure) {
    throw write_error(named_, failure.code().message());
  }
}

}  // namespace psivox::image_io
