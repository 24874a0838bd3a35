
#include <algorithm>

#include "app/command_text.h"
#include "base/text.h"
#include "command_line.h"
#include "psivox/error.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

using Commands = std::span<const HelpCommand>;
using Options = std::span<const HelpOption>;

std::string nothing(Commands) { return {}; }

// --- manual pages in roff: psivox(1), psivox-render(1) and so on

/// Text in roff: a `-` of an option is no hyphen, and no line begins with a request.
std::string roff(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
  }
  if (out.starts_with('.') || out.starts_with('\'')) out.insert(0, "\\&");
  return out;
}

std::string bold(std::string_view text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(std::string_view text) { return "\\fI" + roff(text) + "\\fR"; }

std::string header(const std::string& page, std::string_view summary) {
  if (summary.ends_with('.')) summary.remove_suffix(1);
  std::string title = page;
  for (char& c : title)
    if (c >= 'a' && c <= 'z') c = char(c - 'a' + 'A');
  return ".TH " + title + " 1 \"\" \"psivox " PSIVOX_VERSION "\" \"User Commands\"\n.SH NAME\n" +
         page + " \\- " + roff(summary) + "\n.SH SYNOPSIS\n";
}

std::string entry(const HelpOption& option) {
  std::string text = ".TP\n";
  for (const std::string& name : option.names)
    text += (&name == &option.names.front() ? "" : ", ") + bold(name);
  if (!option.value.empty())
    text += (option.names.empty() ? "" : " ") +
            (option.choices.empty() ? italic(option.value) : roff(option.value));
  text += "\n" + roff(option.help);
  if (!option.usual.empty()) text += " (default: " + roff(option.usual) + ")";
  return text + "\n";
}

std::string examples_section(std::span<const std::string> examples) {
  std::string text = ".SH EXAMPLES\n.nf\n";
  for (const std::string& example : examples) text += roff(example) + "\n";
  return text + ".fi\n";
}

/// The exit codes of error.h.
constexpr std::pair<ExitCode, const char*> exit_statuses[] = {
    {ExitCode::ok, "The work is done."},
    {ExitCode::failure, "Something that no other status names."},
    {ExitCode::usage, "An option is unknown or malformed, or options contradict each other."},
    {ExitCode::input, "A grid or file is missing, corrupt or not supported."},
    {ExitCode::graphics, "No usable EGL device, a limit of the device, or a lost context."},
    {ExitCode::output, "The result cannot be written."},
    {ExitCode::memory, "There is too little memory, or --memory-limit is too small."},
    {ExitCode::verification, "A comparison or a check failed."},
    {ExitCode::interrupted, "Interrupted; no unfinished file is left."},
};

std::string manual_page(const HelpCommand& command, Options options) {
  // the name's line has one sentence
  const std::size_t dot = command.summary.find(". ");
  std::string page = header("psivox-" + command.name, command.summary.substr(0, dot));
  page += bold("psivox " + command.name) + " [OPTIONS]";
  for (const HelpOption& option : options)
    if (option.names.empty()) page += " [" + italic(option.value) + "]";
  if (dot != std::string::npos) page += "\n.SH DESCRIPTION\n" + roff(command.summary);
  page += "\n.SH OPTIONS\n";
  std::string group;
  for (const HelpOption& option : options) {
    if (!option.names.empty() && option.group != group)
      page += ".SS " + roff(group = option.group) + "\n";
    page += entry(option);
  }
  return page + examples_section(command.examples) + ".SH SEE ALSO\n" + bold("psivox") + "(1)\n";
}

std::string manual_of_program(Commands commands) {
  std::string page = header("psivox", "volume renderer for OpenVDB");
  page += bold("psivox") +
          " COMMAND [OPTIONS]\n.SH DESCRIPTION\n"
          "psivox renders OpenVDB volumes to pictures, without a window and without a GPU if there "
          "is none. It chooses a look that suits the file, and how to march it so that the RMS "
          "error stays below a tolerance.\n.SH COMMANDS\n";
  for (const HelpCommand& command : commands)
    page += ".TP\n" + bold("psivox-" + command.name) + "(1)\n" + roff(command.summary) + "\n";
  page += ".TP\n" + bold("--version") +
          "\nprint the versions of psivox, its libraries and the GL renderer\n.TP\n" +
          bold("--help") +
          "[=man|bash|zsh|fish]\nprint a short help, this page, or "
          "the completion of a shell\n.SH EXIT STATUS\n";
  for (const auto& [code, meaning] : exit_statuses)
    page += ".TP\n" + bold(std::to_string(int(code))) + "\n" + roff(meaning) + "\n";
  const std::string examples[] = {
      "psivox info smoke.vdb", "psivox render smoke.vdb -o smoke.png",
      "psivox render smoke.vdb -o smoke.exr --tolerance 1e-4 --aov depth", "psivox view smoke.vdb"};
  page += examples_section(examples) + ".SH SEE ALSO\n";
  for (const HelpCommand& command : commands)
    page += (&command == &commands.front() ? "" : ", ") + bold("psivox-" + command.name) + "(1)";
  return page + "\n";
}

// --- bash: one function for each command, which sets `words` to what may stand there

std::string bash_command(const HelpCommand& command, Options options) {
  std::string text = "_psivox_" + command.name + "() {\n  case $previous in\n", all;
  for (const HelpOption& option : options) {
    for (const std::string& name : option.names) all += name + " ";
    if (option.names.empty() || option.value.empty()) continue;
    text += "    " + joined(option.names, "|") +
            ") words=" + shell_word(joined(option.choices, " ")) + " ;;\n";
  }
  return text + "    *) [[ $current != -* ]] || words=" + shell_word(all) + " ;;\n  esac\n}\n";
}

std::string bash_after(Commands commands) {
  return "_psivox() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} words=\n"
         "  if [[ $current == '=' ]]; then current=\n"
         "  elif [[ $previous == '=' ]]; then previous=${COMP_WORDS[COMP_CWORD-2]}; fi\n"
         "  if ((COMP_CWORD == 1)); then words=" +
         shell_word(joined(names_in(commands, &HelpCommand::name), " ") + " --help --version") +
         "\n"
         "  elif declare -F \"_psivox_${COMP_WORDS[1]}\" >/dev/null; then "
         "\"_psivox_${COMP_WORDS[1]}\"; fi\n"
         "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
         "}\n"
         "complete -o bashdefault -o default -F _psivox psivox\n";  // files where there are no
                                                                    // words
}

// --- zsh

/// In a description or message of _arguments.
std::string zsh_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

std::string zsh_command(const HelpCommand& command, Options options) {
  std::string text = "_psivox_" + command.name + "() {\n  _arguments";
  for (const HelpOption& option : options) {
    std::string value;
    if (!option.value.empty())
      value = ":" + zsh_text(option.value) + ":" +
              (!option.choices.empty() ? "(" + joined(option.choices, " ") + ")"
               : option.takes_file     ? "_files"
                                       : "");
    if (option.names.empty()) text += " \\\n    " + shell_word("*" + value);
    for (const std::string& name : option.names)
      text += " \\\n    " + shell_word("(" + joined(option.names, " ") + ")" + name +
                                       (!value.empty() && name.starts_with("--") ? "=" : "") + "[" +
                                       zsh_text(option.help) + "]" + value);
  }
  return text + "\n}\n";
}

std::string zsh_before(Commands) { return "#compdef psivox\n"; }

std::string zsh_after(Commands commands) {
  std::string text = "_psivox() {\n  local -a commands=(\n";
  for (const HelpCommand& command : commands)
    text += "    " + shell_word(command.name + ":" + zsh_text(command.summary)) + "\n";
  return text +
         "  )\n"
         "  if ((CURRENT == 2)); then _describe command commands; return; fi\n"
         "  local command=$words[2]\n"
         "  shift words\n"
         "  ((CURRENT--))\n"
         "  ((! $+functions[_psivox_$command])) || _psivox_$command\n"
         "}\n"
         "_psivox \"$@\"\n";
}

// --- fish

std::string fish_command(const HelpCommand& command, Options options) {
  const std::string here =
      "complete -c psivox -n '__fish_seen_subcommand_from " + command.name + "'";
  std::string text = "complete -c psivox -n __fish_use_subcommand -f -a " + command.name + " -d " +
                     shell_word(command.summary) + "\n";
  for (const HelpOption& option : options) {
    if (option.names.empty()) continue;
    text += here;
    for (const std::string& name : option.names)
      text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    if (!option.choices.empty())
      text += " -x -a " + shell_word(joined(option.choices, " "));
    else if (!option.value.empty())
      text += option.takes_file ? " -r" : " -x";
    text += " -d " + shell_word(option.help) + "\n";
  }
  return text;
}

constexpr HelpForm forms[] = {
    {"man", false, manual_page, manual_of_program, nothing},
    {"bash", true, bash_command, nothing, bash_after},
    {"zsh", true, zsh_command, zsh_before, zsh_after},
    {"fish", true, fish_command, nothing, nothing},
};

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

const HelpForm& help_form(std::string_view argument) {
  const std::string_view name = argument.substr(argument.find('=') + 1);
  std::string known;
  for (const HelpForm& form : forms) {
    if (form.name == name) return form;
    known += (known.empty() ? "" : ", ") + std::string(form.name);
  }
  throw Error(ExitCode::usage, "--help=" + std::string(name) + ": expected one of " + known);
}

std::vector<const CLI::Option*> arguments_of(const CLI::App& command) {
  return command.get_options([](const CLI::Option* option) { return !option->nonpositional(); });
}

std::vector<const CLI::Option*> options_of(const CLI::App& command, const std::string& group) {
  return command.get_options([&](const CLI::Option* option) {
    return option->nonpositional() && option->get_group() == group;
  });
}

std::vector<std::string> help_groups(const CLI::App& command) {
  std::vector<std::string> groups = command.get_groups();
  std::erase(groups, hidden_group);
  return groups;
}

std::vector<HelpOption> help_options(const CLI::App& command) {
  std::vector<HelpOption> options;
  for (const CLI::Option* option : arguments_of(command)) options.push_back(described(*option));
  for (const std::string& group : help_groups(command))
    for (const CLI::Option* option : options_of(command, group))
      options.push_back(described(*option));
  return options;
}

}  // namespace psivox
