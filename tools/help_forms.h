#pragma once

#include <CLI/App.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace psivox {

/// A command of psivox in a list of them.
struct HelpCommand {
  std::string name, summary;
  std::vector<std::string> examples = {};
};

/// An option or argument of a command as manual pages and completions need it.
struct HelpOption {
  std::vector<std::string> names;    ///< `-o`, `--output`; empty for an argument
  std::string value;                 ///< `FILE`; empty for a flag
  std::string help;                  ///< with its unit, without its default
  std::string usual;                 ///< the default, if any
  std::string group;                 ///< as --help prints it
  std::vector<std::string> choices;  ///< words that the value may be; empty if any text may
  bool takes_file = false;
};

/// What `--help=NAME` prints, made from the same options as --help, so that it cannot be stale:
/// manual pages and completions of shells. The form of the whole program is `before`, then the
/// form of each command if `whole`, then `after`.
struct HelpForm {
  std::string_view name;
  bool whole;  ///< whether the program's form contains the commands' forms
  std::string (*command)(const HelpCommand&, std::span<const HelpOption>);
  std::string (*before)(std::span<const HelpCommand>);
  std::string (*after)(std::span<const HelpCommand>);
};

/// All that --help prints, in its order; arguments first.
std::vector<HelpOption> help_options(const CLI::App& command);

/// The form that an argument `--help=NAME` asks for. Throws Error(usage).
const HelpForm& help_form(std::string_view argument);

}  // namespace psivox
