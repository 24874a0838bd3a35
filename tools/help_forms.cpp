
#include <algorithm>

#include "app/command_text.h"
#include "base/text.h"
#include "command_line.h"
#include "psivox/error.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

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

/// `-o`, `--output`; none of an argument.
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

/// `FILE`; empty for a flag.
std::string value_of(const CLI::Option& option) {
  if (!option.nonpositional()) return option.get_name(/*positional=*/true);
  return option.get_type_size() != 0 ? option.get_type_name() : "";
}

/// Words that the value may be; none if any text may.
std::vector<std::string> choices_of(const CLI::Option& option) {
  const Parameter* parameter =
      option.nonpositional() ? find_parameter(option.get_lnames().front()) : nullptr;
  // --help has a long list of words in the text
  std::vector<std::string> words = split(parameter ? parameter->metavar : value_of(option), '|');
  std::erase_if(words, [](const std::string& word) { return !is_word(word); });
  return words;
}

std::string entry(const CLI::Option& option) {
  std::vector<std::string> words = names_of(option);
  for (std::string& name : words) name = bold(name);
  std::string text = ".TP\n" + joined(words, ", ");
  if (const std::string value = value_of(option); !value.empty())
    text += (words.empty() ? "" : " ") + (choices_of(option).empty() ? italic(value) : roff(value));
  text += "\n" + roff(option.get_description());
  const std::string usual = option.get_default_str();
  return text + (usual.empty() ? "" : " (default: " + roff(usual) + ")") + "\n";
}

}  // namespace

std::string manual_page(const CLI::App& command, std::span<const std::string> examples) {
  const std::string summary = command.get_description();
  std::string name = command.get_name();
  // the name's line has one sentence
  const std::size_t dot = summary.find(". ");
  const std::string synopsis = bold(name) + " [OPTIONS]";
  std::ranges::replace(name, ' ', '-');
  std::string page = header(name, summary.substr(0, dot)) + synopsis, entries, group;
  for (const CLI::Option* option : help_options(command)) {
    if (!option->nonpositional())
      page += " [" + italic(value_of(*option)) + "]";
    else if (option->get_group() != group)
      entries += ".SS " + roff(group = option->get_group()) + "\n";
    entries += entry(*option);
  }
  if (dot != std::string::npos) page += "\n.SH DESCRIPTION\n" + roff(summary);
  return page + "\n.SH OPTIONS\n" + entries + examples_section(examples) + ".SH SEE ALSO\n" +
         bold("psivox") + "(1)\n";
}

std::string manual_of_program(std::span<const std::pair<std::string, std::string>> commands) {
  std::string page = header("psivox", "volume renderer for OpenVDB");
  page += bold("psivox") +
          " COMMAND [OPTIONS]\n.SH DESCRIPTION\n"
          "psivox renders OpenVDB volumes to pictures, without a window and without a GPU if there "
          "is none. It chooses a look that suits the file, and how to march it so that the RMS "
          "error stays below a tolerance.\n.SH COMMANDS\n";
  std::vector<std::string> pages;
  for (const auto& [name, summary] : commands) {
    pages.push_back(bold("psivox-" + name) + "(1)");
    page += ".TP\n" + pages.back() + "\n" + roff(summary) + "\n";
  }
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
  return page + examples_section(examples) + ".SH SEE ALSO\n" + joined(pages, ", ") + "\n";
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
  for (const CLI::Option* option : help_options(command)) {
    const std::vector<std::string> names = names_of(*option);
    const auto has = [&](const std::string& name) { return std::ranges::count(names, name); };
    const bool after = words.size() > 1 && has(words[words.size() - 2]);
    if (!value_of(*option).empty() && (after || (assigned != current && has(assigned)))) {
      std::string choices;
      for (const std::string& choice : choices_of(*option))
        choices += (after ? "" : assigned + "=") + choice + "\n";
      return choices;
    }
    for (const std::string& name : names)
      if (current.starts_with('-')) all += name + "\t" + option->get_description() + "\n";
  }
  return all;
}

std::vector<const CLI::Option*> help_options(const CLI::App& command) {
  std::vector<const CLI::Option*> options = command.get_options(
      [](const CLI::Option* option) { return option->get_group() != hidden_group; });
  const std::vector<std::string> groups = command.get_groups();
  std::ranges::stable_sort(options, {}, [&](const CLI::Option* option) {
    return option->nonpositional() ? std::ranges::find(groups, option->get_group()) - groups.begin()
                                   : -1;
  });
  return options;
}

}  // namespace psivox
