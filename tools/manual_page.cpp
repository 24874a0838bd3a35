// Manual pages in roff: psivox(1), psivox-render(1) and so on.

#include "base/text.h"
#include "help_forms.h"
#include "psivox/error.h"

namespace psivox {
namespace {

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
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
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

}  // namespace

std::string manual_page(const HelpCommand& command, std::span<const HelpOption> options) {
  std::string page = header("psivox-" + command.name, command.summary);
  page += bold("psivox " + command.name) + " [OPTIONS]";
  for (const HelpOption& option : options)
    if (option.names.empty()) page += " [" + italic(option.value) + "]";
  page += "\n.SH OPTIONS\n";
  std::string group;
  for (const HelpOption& option : options) {
    if (!option.names.empty() && option.group != group)
      page += ".SS " + roff(group = option.group) + "\n";
    page += entry(option);
  }
  return page + examples_section(command.examples) + ".SH SEE ALSO\n" + bold("psivox") + "(1)\n";
}

std::string manual_of_program(std::span<const HelpCommand> commands) {
  std::string page = header("psivox", "volume renderer for OpenVDB");
  page += bold("psivox") +
          " COMMAND [OPTIONS]\n.SH DESCRIPTION\n"
          "psivox renders OpenVDB volumes to pictures, without a window and without a GPU if there "
          "is none. It chooses a look that suits the file, and how to march it so that the RMS "
          "error stays below a tolerance.\n.SH COMMANDS\n";
  for (const HelpCommand& command : commands)
    page += ".TP\n" + bold("psivox-" + command.name) + "(1)\n" + roff(command.summary) + "\n";
  page += ".TP\n" + bold("--version") +
          "\nprint the versions of psivox, its libraries and the GL "
          "renderer\n.TP\n" +
          bold("--help") +
          "[=man|bash|zsh|fish]\nprint a short help, this page, or "
          "the completion of a shell\n.SH EXIT STATUS\n";
  for (const auto& [code, meaning] : exit_statuses)
    page += ".TP\n" + bold(std::to_string(static_cast<int>(code))) + "\n" + roff(meaning) + "\n";
  const std::string examples[] = {
      "psivox info smoke.vdb", "psivox render smoke.vdb -o smoke.png",
      "psivox render smoke.vdb -o smoke.exr --tolerance 1e-4 --aov depth", "psivox view smoke.vdb"};
  page += examples_section(examples) + ".SH SEE ALSO\n";
  for (const HelpCommand& command : commands)
    page += (&command == &commands.front() ? "" : ", ") + bold("psivox-" + command.name) + "(1)";
  return page + "\n";
}

}  // namespace psivox
