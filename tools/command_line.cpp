#include "command_line.h"

#include <CLI/Config.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <sstream>

#include "psivox/error.h"
#include "psivox/text.h"

namespace psivox {
namespace {

constexpr const char* general_group = "Options";

[[noreturn]] void fail(const std::string& message) { throw Error(ExitCode::usage, message); }

constexpr int help_column = 34;
constexpr std::size_t help_width = 66;

/// With line breaks between words, which CLI11 indents but does not make.
std::string wrapped(const std::string& text) {
  std::string out;
  std::size_t column = 0;
  std::istringstream words(text);
  for (std::string word; words >> word; column += word.size() + 1) {
    if (column + word.size() > help_width && column > 0) {
      out.back() = '\n';
      column = 0;
    }
    out += word + " ";
  }
  if (!out.empty()) out.pop_back();
  return out;
}

std::string full_help(const Parameter& p) {
  std::string text = p.help;
  if (!p.unit.empty()) text += " [" + p.unit + "]";
  return text + " (default: " + p.default_text + ")";
}

std::string names(const std::string& name, char short_name) {
  return short_name ? std::string("-") + short_name + "," + name : name;
}

}  // namespace

CommandLine::CommandLine(const std::string& command, const std::string& summary)
    : app_(summary, "psivox " + command) {
  app_.get_formatter()->column_width(help_column);
  kinds_["--help"] = kinds_["-h"] = {"--help"};
}

CLI::Option* CommandLine::add(const Kind& kind, char short_name, CLI::Option* option,
                              const std::string& group) {
  kinds_[kind.name] = kind;
  if (short_name) kinds_[std::string("-") + short_name] = kind;
  option->group(group);
  if (!kind.value.empty()) option->type_name(kind.value)->take_last();
  return option;
}

void CommandLine::add_value(const std::string& name, char short_name, const std::string& metavar,
                            const std::string& help, std::string& value) {
  add({name, metavar}, short_name, app_.add_option(names(name, short_name), value, wrapped(help)),
      general_group);
}

void CommandLine::add_flag(const std::string& name, char short_name, const std::string& help,
                           bool& value) {
  add({name}, short_name, app_.add_flag(names(name, short_name), value, wrapped(help)),
      general_group);
}

void CommandLine::add_positional(const std::string& metavar, const std::string& help,
                                 std::string& value) {
  app_.add_option(metavar, value, help)->type_name("");
  ++positionals_;
}

void CommandLine::add_parameters(std::vector<Setting>& settings,
                                 const std::function<bool(std::string_view name)>& wanted) {
  for (const Parameter& p : parameters()) {
    if (wanted && !wanted(p.name)) continue;
    const std::function<void(const std::string&)> take = [&settings, &p](const std::string& text) {
      settings.push_back({p.name, text});
    };
    if (p.positional) {
      app_.add_option_function(p.metavar, take, p.help)->type_name("");
      ++positionals_;
      continue;
    }
    const bool optional = std::holds_alternative<bool Scene::*>(p.member);
    const Kind kind{"--" + p.name, optional ? "[=true|false]" : p.metavar, optional};
    add(kind, 0, app_.add_option_function("--" + p.name, take, wrapped(full_help(p))),
        group_name(p.group));
  }
}

const CommandLine::Kind& CommandLine::kind_of(const std::string& option) const {
  const auto found = kinds_.find(option);
  if (found != kinds_.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [name, kind] : kinds_) {
    if (option.size() > 2) known.push_back(name);  // one letter is near any other
  }
  fail("unknown option " + option + suggestion(option, known));
}

std::vector<std::string> CommandLine::normalised(std::span<const std::string> arguments,
                                                 bool& help) const {
  std::vector<std::string> options, positional;
  bool only_positional = false;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (only_positional || argument.size() < 2 || argument[0] != '-') {
      positional.push_back(argument);
      continue;
    }
    if (argument == "--") {
      only_positional = true;
      continue;
    }
    // --name, --name=value, -s, -svalue
    const bool is_long = argument[1] == '-';
    const std::size_t name_end = is_long ? std::min(argument.find('='), argument.size()) : 2;
    const std::string name = argument.substr(0, name_end);
    const Kind& kind = kind_of(name);
    const bool attached = name_end < argument.size();
    const std::string attached_value =
        attached ? argument.substr(name_end + (is_long ? 1 : 0)) : std::string();
    if (kind.value.empty()) {
      if (attached) fail(name + " takes no value, but " + in_quotes(attached_value) + " was given");
      if (kind.name == "--help") help = true;
      options.push_back(kind.name);
      continue;
    }
    options.push_back(kind.name);
    if (attached) {
      options.push_back(attached_value);
    } else if (kind.optional) {
      options.push_back("true");
    } else {
      const bool is_value = i + 1 < arguments.size() && !kinds_.contains(arguments[i + 1]) &&
                            !arguments[i + 1].starts_with("--");
      if (!is_value) fail(name + " needs a value: " + kind.value);
      options.push_back(arguments[++i]);
    }
  }
  if (positional.size() > positionals_)
    fail("unexpected argument " + in_quotes(positional[positionals_]));
  if (!positional.empty()) options.push_back("--");
  options.insert(options.end(), positional.begin(), positional.end());
  return options;
}

bool CommandLine::parse(std::span<const std::string> arguments) {
  bool help = false;
  std::vector<std::string> all = normalised(arguments, help);
  if (help) {
    std::cout << app_.help();
    return false;
  }
  std::reverse(all.begin(), all.end());  // as CLI11 wants them
  try {
    app_.parse(all);
  } catch (const CLI::ParseError& error) {
    fail(error.what());
  }
  return true;
}

double read_limit(const std::string& option, const std::string& text) {
  double value = 0;
  if (!read_number(text, value) || !std::isfinite(value) || value < 0)
    fail(option + " " + in_quotes(text) + ": expected a number at least 0");
  return value;
}

}  // namespace psivox
