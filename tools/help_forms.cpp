
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

// --- completions: a shell asks the program what may stand in the place of the last word

constexpr std::pair<std::string_view, const char*> completion_scripts[] = {
    {"bash", R"script(_psivox() {
  local current=${COMP_WORDS[COMP_CWORD]#=} word words=()
  for word in "${COMP_WORDS[@]:0:COMP_CWORD}"; do [[ $word == '=' ]] || words+=("$word"); done
  mapfile -t COMPREPLY < <(compgen -W "$("${words[0]}" --complete "${words[@]:1}" "$current" \
    2>/dev/null | cut -f1)" -- "$current")
}
complete -o bashdefault -o default -F _psivox psivox
)script"},
    {"zsh", R"script(#compdef psivox
_psivox() {
  local -a found
  found=("${(@f)$(${words[1]} --complete "${(@)words[2,CURRENT]}" 2>/dev/null |
    sed 's/:/\\:/g; s/\t/:/')}")
  [[ -n ${found[1]} ]] && _describe psivox found || _files
}
_psivox "$@"
)script"},
    {"fish", R"script(function __psivox_complete
  set -l words (commandline -opc)
  set -l found ($words[1] --complete $words[2..] (commandline -ct) 2>/dev/null)
  if count $found >/dev/null
    printf '%s\n' $found
  else
    __fish_complete_path (commandline -ct)
  end
end
complete -c psivox -f -a '(__psivox_complete)'
)script"},
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
  return result;
}

}  // namespace

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

std::string completion_script(std::string_view shell) {
  for (const auto& [name, script] : completion_scripts)
    if (name == shell) return script;
  throw Error(ExitCode::usage,
              "--help=" + std::string(shell) + ": expected one of man, bash, zsh, fish");
}

std::string completions(const CLI::App& command, std::span<const std::string> words) {
  const std::string& current = words.back();
  const std::string assigned = current.substr(0, current.find('='));
  std::string all;
  for (const HelpOption& option : help_options(command)) {
    const auto has = [&](const std::string& name) {
      return std::ranges::count(option.names, name);
    };
    const bool after = words.size() > 1 && has(words[words.size() - 2]);
    if (!option.value.empty() && (after || (assigned != current && has(assigned)))) {
      std::string choices;
      for (const std::string& choice : option.choices)
        choices += (after ? "" : assigned + "=") + choice + "\n";
      return choices;
    }
    for (const std::string& name : option.names)
      if (current.starts_with('-')) all += name + "\t" + option.help + "\n";
  }
  return all;
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
