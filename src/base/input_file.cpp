#include "base/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <vector>

namespace psivox {
namespace {

namespace fs = std::filesystem;

std::atomic<InputProtection*> protection = nullptr;
thread_local int earlier_outputs = 0;

std::vector<std::string>& typed_words() {
  static std::vector<std::string> words;
  return words;
}

/// Whether it is a word, or a part of one such as `--scene=NAME`, `NAME:CAMERA` or "NAME grid=x".
bool was_typed(const std::string& name) {
  const auto holds = [&](const std::string& word) {
    for (std::size_t at = word.find(name); at != word.npos; at = word.find(name, at + 1)) {
      const std::size_t end = at + name.size();
      if ((at == 0 || std::strchr("= ,", word[at - 1])) &&
          (end == word.size() || std::strchr(" ,:", word[end])))
        return true;
    }
    return false;
  };
  return !name.empty() && std::ranges::any_of(typed_words(), holds);
}

}  // namespace

void allow_typed_names(std::span<const std::string> words) {
  typed_words().assign(words.begin(), words.end());
}

int open_input(const fs::path& path, std::string& why) {
  const bool typed = was_typed(path.string());
  // without O_NONBLOCK, a pipe that nobody writes to would be waited for here
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | (typed ? 0 : O_NONBLOCK));
  struct stat facts {};
  if (file < 0 || ::fstat(file, &facts) != 0) {
    why = std::strerror(errno);
  } else if (S_ISDIR(facts.st_mode)) {
    why = std::strerror(EISDIR);
  } else if (!typed && !S_ISREG(facts.st_mode)) {
    why = "it is a pipe or a device, which is read only where the command line names it";
  } else {
    if (InputProtection* const kept = protection; kept && S_ISREG(facts.st_mode))
      kept->add({facts.st_dev, facts.st_ino}, path);
    return file;
  }
  if (file >= 0) ::close(file);
  return -1;
}

InputProtection::InputProtection() { protection = this; }
InputProtection::~InputProtection() { protection = nullptr; }

void InputProtection::add(File file, const fs::path& path) {
  if (earlier_outputs > 0) return;
  const std::lock_guard lock(mutex_);
  inputs_.try_emplace(file, path.string());
}

void InputProtection::expect(const fs::path& path) {
  struct stat facts {};
  InputProtection* const kept = protection;
  if (kept && ::stat(path.c_str(), &facts) == 0 && S_ISREG(facts.st_mode))
    kept->add({facts.st_dev, facts.st_ino}, path);
}

void InputProtection::except(int descriptor) {
  struct stat facts {};
  InputProtection* const kept = protection;
  if (!kept || ::fstat(descriptor, &facts) != 0) return;
  const std::lock_guard lock(kept->mutex_);
  kept->inputs_[{facts.st_dev, facts.st_ino}].clear();
}

std::string InputProtection::input_at(const fs::path& path) {
  struct stat facts {};
  InputProtection* const kept = protection;
  if (!kept || ::stat(path.c_str(), &facts) != 0) return {};
  const std::lock_guard lock(kept->mutex_);
  const auto found = kept->inputs_.find({facts.st_dev, facts.st_ino});
  return found == kept->inputs_.end() ? std::string() : found->second;
}

EarlierOutput::EarlierOutput() { ++earlier_outputs; }
EarlierOutput::~EarlierOutput() { --earlier_outputs; }

}  // namespace psivox
