#include "help_option.h"

#include <algorithm>

#include "command_line.h"
#include "psivox/parameters.h"
#include "psivox/text.h"

namespace psivox {
namespace {

/// Whether a part of a metavar stands for itself, as `auto` does and `N` does not.
bool is_word(const std::string& part) {
  return !part.empty() && std::all_of(part.begin(), part.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
}

HelpOption described(const CLI::Option& option) {
  HelpOption result;
  for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
  const Parameter* parameter =
      option.get_lnames().empty() ? nullptr : find_parameter(option.get_lnames().front());
  if (!option.nonpositional())
    result.value = option.get_name(/*positional=*/true);
  else if (option.get_type_size() != 0)
    result.value = option.get_type_name();
  result.help = option.get_description();
  result.usual = option.get_default_str();
  result.group = option.get_group();
  // --help has a long list of words in the text
  for (const std::string& part : split(parameter ? parameter->metavar : result.value, '|'))
    if (is_word(part)) result.choices.push_back(part);
  result.takes_file = result.value.find("FILE") != std::string::npos || !option.nonpositional();
  return result;
}

}  // namespace

std::vector<HelpOption> help_options(const CLI::App& command) {
  std::vector<HelpOption> arguments, options;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group() == hidden_group) continue;
    (option->nonpositional() ? options : arguments).push_back(described(*option));
  }
  // groups keep the order of their first options
  std::vector<std::string> groups;
  for (const HelpOption& option : options)
    if (std::find(groups.begin(), groups.end(), option.group) == groups.end())
      groups.push_back(option.group);
  for (const std::string& group : groups)
    std::copy_if(options.begin(), options.end(), std::back_inserter(arguments),
                 [&](const HelpOption& option) { return option.group == group; });
  return arguments;
}

}  // namespace psivox
