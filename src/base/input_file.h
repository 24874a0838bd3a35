#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <utility>

namespace psivox {

/// Opens a file for reading. A pipe or a device is opened only if the user typed its name: to read
/// from one that a file names may never end. Returns its descriptor, or -1 and sets `why`.
int open_input(const std::filesystem::path& path, std::string& why);

/// The words that the user typed.
void allow_typed_names(std::span<const std::string> words);

/// While it lives, HiddenFile replaces no file that open_input() has opened: nothing that a call
/// reads is lost by what it writes, whatever names and links lead there. There is one at a time.
class InputProtection {
 public:
  InputProtection();
  ~InputProtection();
  InputProtection(const InputProtection&) = delete;
  InputProtection& operator=(const InputProtection&) = delete;

  /// A file that will be read.
  static void expect(const std::filesystem::path& path);
  /// What psivox wrote is no input: its descriptor.
  static void except(int descriptor);
  /// The input that is the file at `path`, by the name under which it was read; empty if none is.
  static std::string input_at(const std::filesystem::path& path);

 private:
  friend int open_input(const std::filesystem::path& path, std::string& why);
  using File = std::pair<std::uint64_t, std::uint64_t>;  ///< its device and number
  void add(File file, const std::filesystem::path& path);

  std::mutex mutex_;
  std::map<File, std::string> inputs_;  ///< empty name: psivox wrote it
};

/// While it lives, what this thread reads is what an earlier call wrote, and may be written again.
class EarlierOutput {
 public:
  EarlierOutput();
  ~EarlierOutput();
  EarlierOutput(const EarlierOutput&) = delete;
  EarlierOutput& operator=(const EarlierOutput&) = delete;
};

}  // namespace psivox
