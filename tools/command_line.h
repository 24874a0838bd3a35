#pragma once

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "psivox/parameters.h"

namespace psivox {

/// The options of one command. CLI11 keeps them and prints the help; the arguments are brought into
/// one form first, because whether `-1,2,3` is a value follows from the option before it.
class CommandLine {
 public:
  CommandLine(const std::string& command, const std::string& summary);

  /// `--name VALUE`, and `-s VALUE` where a short letter is given. The last one given wins.
  void add_value(const std::string& name, char short_name, const std::string& metavar,
                 const std::string& help, std::string& value);
  void add_flag(const std::string& name, char short_name, const std::string& help, bool& value);
  void add_positional(const std::string& metavar, const std::string& help, std::string& value);
  /// Parameters of the scene, every one or those wanted; what was given is appended to `settings`.
  void add_parameters(std::vector<Setting>& settings,
                      const std::function<bool(std::string_view name)>& wanted = {});

  /// False if the help was asked for and printed. Throws Error(usage).
  bool parse(std::span<const std::string> arguments);

 private:
  struct Kind {
    std::string name = {};   ///< --name
    std::string value = {};  ///< metavar; empty for a flag
    bool optional = false;   ///< --name alone means --name=true
  };

  CLI::Option* add(const Kind& kind, char short_name, CLI::Option* option,
                   const std::string& group);
  const Kind& kind_of(const std::string& option) const;
  /// Options as pairs `--name`, `value`, then `--`, then the positional arguments.
  std::vector<std::string> normalised(std::span<const std::string> arguments, bool& help) const;

  CLI::App app_;
  std::map<std::string, Kind> kinds_;  ///< by `--name` and `-s`
  std::size_t positionals_ = 0;
};

/// A number >= 0 as the value of `option`. Throws Error(usage).
double read_limit(const std::string& option, const std::string& text);

}  // namespace psivox
