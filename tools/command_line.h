#pragma once

#include <CLI/App.hpp>
#if __has_include(<CLI/ExtraValidators.hpp>)  // since 2.6
#include <CLI/ExtraValidators.hpp>
#endif
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "psivox/scene.h"

namespace psivox {

/// The options of one command: CLI11's, including the scene's parameters, with psivox's errors and
/// help. If an option is given twice, the last value counts.
class CommandLine : public CLI::App {
 public:
  /// `common`: names of the command's own options that --help lists, beside the parameters that the
  /// table calls common; without any, it lists all. `examples`: what follows `psivox COMMAND`.
  CommandLine(const std::string& command, const std::string& summary,
              std::vector<std::string> common = {}, const std::vector<std::string>& examples = {});

  /// Options that follow are listed under this heading.
  void begin_group(const std::string& heading) { option_defaults()->group(heading); }
  /// An option with a value, or an argument of no metavar.
  template <typename T>
  CLI::Option* add_value(const std::string& name, T& value, const std::string& metavar,
                         const std::string& help) {
    return add_option(name, value, help)->type_name(metavar);
  }
  /// `name` takes items separated by commas; several uses append their items.
  CLI::Option* add_list(const std::string& name, std::vector<std::string>& items,
                        const std::string& help);
  /// Adds the scene's parameters, all or those wanted. Given values are appended to `settings`.
  void add_parameters(std::vector<Setting>& settings,
                      const std::function<bool(const Parameter&)>& wanted = {});

  /// Adds --trust, which takes effect when it is read.
  void add_trust();

  /// Returns false if it printed the help that was asked for. Throws Error(usage).
  bool read(std::span<const std::string> arguments);

 private:
  /// Refuses arguments that CLI11 has left over.
  void check_remaining() const;
  /// Prints the common options or all, and the examples at the end, where the eye is.
  void print_help(bool all) const;

  std::vector<std::string> common_, examples_;
};

/// `arguments` follow the command's name. Commands throw Error; psivox.cpp turns it into a message
/// and an exit code.
using Arguments = std::span<const std::string>;

void render_command(Arguments arguments);
void info_command(Arguments arguments);
void compare_command(Arguments arguments);
void study_command(Arguments arguments);
void verify_command(Arguments arguments);
void view_command(Arguments arguments);
void examples_command(Arguments arguments);

/// The files that `psivox examples` draws, by name.
const std::map<std::string, std::string>& example_files();

[[noreturn]] inline void usage(const std::string& message) {
  throw Error(ExitCode::usage, message);
}

/// The process ends with exit code 1, this message and no unfinished files, if it still runs then.
void end_after(int seconds, const char* message);

/// The group of options that --help does not list. CLI11's own, "", omits their names from its
/// errors.
inline constexpr const char* hidden_group = "Hidden";

/// Checks that an option's value is one of these.
template <typename T>
CLI::Validator one_of(const std::vector<T>& values) {
  return CLI::IsMember(values).description("");
}

/// Checks that an option's value is a finite number of that type in the range. CLI11's own Range
/// accepts NaN and prints limits with 300 digits.
template <typename Number>
CLI::Validator number_in(const Range& range) {
  const auto check = [range](const std::string& text) {
    Number value{};
    if (read_number(text, value) && std::isfinite(double(value)) && range.contains(double(value)))
      return std::string();
    return std::string("expected ") + (std::is_integral_v<Number> ? "a whole number" : "a number") +
           range.text() + ", not " + in_quotes(text);
  };
  return {check, ""};
}

/// The scene of a command line: the scene of a file, with the camera of another, overridden by
/// options.
class SceneOptions {
 public:
  /// Adds all options but the parameters in `without`.
  void add_to(CommandLine& line, const std::vector<std::string>& without);

  /// Sets a parameter as the command line would.
  void set(const std::string& name, const std::string& text) { settings_.push_back({name, text}); }

  /// What to say about the colours that the command line gives.
  std::vector<std::string> notices() const;

  /// Returns the scene, validated but not resolved. `base` supplies what the file does not set.
  /// Throws Error(usage), Error(input).
  Scene scene(Scene base = {});

  /// The layers that the picture of --scene was drawn with, once scene() was called.
  const std::vector<std::string>& layers() const { return layers_; }

  /// The file of --scene; empty if it was not given.
  const std::string& file() const { return file_; }

 private:
  std::string file_, camera_;
  std::vector<Setting> settings_;
  std::vector<std::string> layers_;
};

/// Whether Z is up, by the scene or else by its input, the first file of a sequence.
bool file_z_is_up(const Scene& scene);

/// The options that say which frames a command works on.
struct FrameOptions {
  std::vector<std::string> inputs;
  std::string frames;             ///< empty: all
  std::string auto_from;          ///< empty: the first, the middle and the last; `all`
  std::string missing = "error";  ///< or `skip`, `hold`

  /// Begins their section of --help.
  void add_to(CommandLine& line);
};

/// The manual page of a command, made from the same options as --help.
std::string manual_page(const CLI::App& command, std::span<const std::string> examples);
/// The manual page of the program. `commands`: their names and summaries.
std::string manual_of_program(std::span<const std::pair<std::string, std::string>> commands);

/// The script by which a shell completes psivox's command lines: it runs `psivox --complete` with
/// the words up to the cursor. Throws Error(usage) for another shell than bash, zsh and fish.
std::string completion_script(std::string_view shell);
/// What may stand in the place of the last of a command's words, a line for each, with its meaning
/// behind a tab; empty if it may be any text, such as the name of a file.
std::string completions(const CLI::App& command, std::span<const std::string> words);

/// All options of a command that help lists: arguments first, then by groups.
std::vector<const CLI::Option*> help_options(const CLI::App& command);

}  // namespace psivox
