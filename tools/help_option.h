#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

namespace psivox {

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

/// All that --help prints, in its order; arguments first.
std::vector<HelpOption> help_options(const CLI::App& command);

}  // namespace psivox
