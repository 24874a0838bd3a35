#include "command_line.h"

#include <CLI/Config.hpp>     // which CLI::App makes
#include <CLI/Formatter.hpp>  // the same
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "app/command_text.h"
#include "psivox/open.h"
#include "psivox/picture_file.h"
#include "psivox/sequence.h"
#include "psivox/vdb.h"

namespace psivox {
namespace {

constexpr std::size_t option_width = 34, text_width = 66;
constexpr std::size_t longest_metavar = 40;  ///< a longer list of words moves to the help text

/// Breaks lines between words.
std::string wrapped(const std::string& text, const std::string& next_line,
                    std::size_t width = text_width) {
  std::string out;
  std::size_t column = 0;
  std::istringstream words(text);
  for (std::string word; words >> word; column += word.size() + 1) {
    if (column + word.size() > width && column > 0) {
      out.pop_back();
      out += next_line;
      column = 0;
    }
    out += word + " ";
  }
  if (!out.empty()) out.pop_back();
  return out;
}

/// "  --name METAVAR   help (default: value)". CLI11's own lay-out changes with its version.
std::string help_row(const CLI::Option& option) {
  const bool named = option.nonpositional();
  std::string row = "  " + option.get_name(!named, named);
  if (!option.get_option_text().empty())
    row += option.get_option_text();
  else if (option.get_type_size() != 0)
    row += " " + option.get_type_name();
  const std::string next_line = "\n" + std::string(option_width, ' ');
  row += row.size() < option_width ? std::string(option_width - row.size(), ' ') : next_line;
  const std::string usual = option.get_default_str();
  const std::string help =
      option.get_description() + (usual.empty() ? "" : " (default: " + usual + ")");
  return row + wrapped(help, next_line) + "\n";
}

/// Whether a word is the volume of a command, not the text of an option that may go without one.
bool is_input(const std::string& word) {
  std::error_code unknown;
  return has_volume_name(word) || std::filesystem::exists(word, unknown);
}

/// The arguments with each text of such an option behind its =.
std::vector<std::string> with_titles(std::span<const std::string> arguments) {
  std::vector<std::string> joined;
  bool takes_text = false;
  for (const std::string& word : arguments) {
    if (takes_text && !word.starts_with('-') && !is_input(word))
      joined.back() += "=" + word;
    else
      joined.push_back(word);
    const Parameter* p = word.starts_with("--") ? find_parameter(word.substr(2)) : nullptr;
    takes_text = p && std::holds_alternative<std::optional<std::string> Scene::*>(p->member);
  }
  return joined;
}

std::string help_text(const Parameter& p) {
  std::string text = p.help;
  if (p.metavar.size() > longest_metavar) text += ": " + joined(split(p.metavar, '|'), ", ");
  return p.unit.empty() ? text : text + " [" + p.unit + "]";
}

}  // namespace

CommandLine::CommandLine(const std::string& command, const std::string& summary,
                         std::vector<std::string> common, const std::vector<std::string>& examples)
    : CLI::App(summary, "psivox " + command), common_(std::move(common)) {
  for (const std::string& example : examples)
    examples_.push_back(get_name() + (example.empty() ? "" : " ") + example);
  begin_group("Options");  // CLI11 2.6 has another name
  set_help_flag("-h,--help", "print a short help; --help=man, =bash, =zsh or =fish in that form");
  set_help_all_flag("--help-all", "print every option");
  option_defaults()->take_last();
  allow_extras();  // so that check_remaining() can suggest the right name
}

CLI::Option* CommandLine::add_list(const std::string& name, std::vector<std::string>& items,
                                   const std::string& help) {
  return add_value(name, items, "LIST", help)->delimiter(',')->allow_extra_args(false)->take_all();
}

void CommandLine::add_parameters(std::vector<Setting>& settings,
                                 const std::function<bool(const Parameter&)>& wanted) {
  for (const Parameter& p : parameters()) {
    if (wanted && !wanted(p)) continue;
    const std::function<void(const std::string&)> take = [&settings, &p](const std::string& text) {
      settings.push_back({p.name, text});
    };
    if (p.positional) {
      add_option_function(p.metavar, take, p.help)->type_name("");
      continue;
    }
    CLI::Option* option = nullptr;
    const bool surfaces = std::holds_alternative<std::vector<ShownSurface> Scene::*>(p.member);
    if (surfaces || std::holds_alternative<std::vector<DirectionalLight> Scene::*>(p.member) ||
        std::holds_alternative<std::vector<std::string> Scene::*>(p.member))
      option = add_option_function<std::vector<std::string>>(
                   "--" + p.name + (p.name == "volumes" ? ",--and" : ""),
                   [&settings, &p, surfaces](const std::vector<std::string>& items) {
                     settings.push_back({p.name, joined(items, surfaces ? "," : ";")});
                   })
                   ->type_name(p.metavar)
                   ->allow_extra_args(false)
                   ->take_all();
    else if (std::holds_alternative<std::optional<std::string> Scene::*>(p.member))
      option = add_flag("--" + p.name)->each(take)->option_text(" " + p.metavar);
    else if (std::holds_alternative<bool Scene::*>(p.member))
      option = add_flag("--" + p.name)->each(take)->option_text("[=true|false]");
    else
      option = add_option_function("--" + p.name, take)
                   ->type_name(p.metavar.size() > longest_metavar ? "NAME" : p.metavar);
    if (p.common) common_.push_back(p.name);
    option->description(help_text(p))->group(group_name(p.group))->default_str(p.default_text);
  }
}

// psivox::usage: CLI::App has a `usage` of its own since 2.4.
void CommandLine::check_remaining() const {
  for (const std::string& argument : remaining()) {
    if (argument == "--") continue;
    if (!argument.starts_with("-")) psivox::usage("unexpected argument " + in_quotes(argument));
    const std::string name = argument.substr(0, argument.find('='));
    std::vector<std::string> known;
    for (const CLI::Option* option : get_options())
      if (option->nonpositional() && option->get_group() != hidden_group && name.starts_with("--"))
        known.push_back("--" + option->get_lnames().front());
    const std::string meant = option_of_concept(name);
    psivox::usage("unknown option " + name +
                  (std::ranges::count(known, meant) ? "; " + meant + " does that here"
                                                    : suggestion(name, known)));
  }
}

void CommandLine::add_trust() {
  const auto take = [](const std::string& text) {
    if (text == "no")
      trust_files(Trust::no);
    else if (text == "if-needed")
      trust_files(Trust::if_needed);
    else if (text == "yes" || text == "true")
      trust_files(Trust::yes);
    else
      psivox::usage("--trust " + in_quotes(text) + ": expected no, if-needed or yes");
  };
  add_flag("--trust")
      ->each(take)
      ->option_text("[=no|if-needed|yes]")
      ->description(
          "how to read files of volumes: no: in a process that the kernel restricts, or not at "
          "all; "
          "if-needed (default): in a process with the limits that this system has; yes, or --trust "
          "alone: without limits, so that a hostile file can crash psivox or run code")
      ->group(group_name(ParameterGroup::input));
}

void CommandLine::print_help(bool all) const {
  std::string line = "\nUsage: " + get_name() + " [OPTIONS]", text, group;
  std::vector<const CLI::Option*> shown = help_options(*this);
  const std::size_t count = shown.size();
  const bool brief = !all && !common_.empty();
  if (brief) {
    shown = get_options([&](const CLI::Option* option) {
      return !option->nonpositional() || std::ranges::count(common_, option->get_lnames().front());
    });
    std::ranges::stable_partition(shown, [](auto* option) { return !option->nonpositional(); });
  }
  for (const CLI::Option* option : shown) {
    const bool argument = !option->nonpositional();
    const std::string name = option->get_name(true) + (option->get_expected_max() > 1 ? "..." : "");
    if (argument) line += option->get_required() ? " " + name : " [" + name + "]";
    const std::string own = argument ? "Arguments" : brief ? "Common options" : option->get_group();
    if (own != group) text += "\n" + (group = own) + ":\n";
    text += help_row(*option);
  }
  text += "\n";
  if (brief)
    text += get_name() + " --help-all prints all " + std::to_string(count) + " options.\n\n";
  text += examples_.size() > 1 ? "Examples:\n  " : "Example:\n  ";
  std::cout << wrapped(get_description(), "\n", option_width + text_width) << line << "\n"
            << text << joined(examples_, "\n  ") << "\n";
}

bool CommandLine::read(std::span<const std::string> arguments) {
  if (arguments.size() == 1 && arguments.front() == "--help=all") {
    print_help(true);
    return false;
  }
  if (arguments.size() == 1 && arguments.front().starts_with("--help=")) {
    const std::string form = arguments.front().substr(7);
    std::cout << (form == "man" ? manual_page(*this, examples_) : completion_script(form));
    return false;
  }
  if (arguments.size() > 1 && arguments.front() == "--complete") {
    std::cout << completions(*this, arguments.subspan(1));
    return false;
  }
  try {
    std::vector<std::string> words = with_titles(arguments);
    std::ranges::reverse(words);
    parse(std::move(words));
  } catch (const CLI::CallForHelp&) {
    print_help(false);
    return false;
  } catch (const CLI::CallForAllHelp&) {
    print_help(true);
    return false;
  } catch (const CLI::ArgumentMismatch&) {  // thrown if an option at the end has no value
    psivox::usage(arguments.back() + " needs a value");
  } catch (const CLI::ParseError& error) {
    psivox::usage(error.what());
  }
  check_remaining();
  return true;
}

bool file_z_is_up(const Scene& scene) {
  if (scene.up_axis != UpAxis::automatic || scene.input.empty()) return scene.up_axis == UpAxis::z;
  const auto files = sequence_files(std::vector{scene.input});
  return !VolumeFile(files ? files->begin()->second : scene.input).z_up().empty();
}

void SceneOptions::add_to(CommandLine& line, const std::vector<std::string>& without) {
  line.begin_group(group_name(ParameterGroup::input));
  line.add_value(
      "--scene", file_, "FILE",
      "read parameters from a .json, or from a picture that psivox wrote; - is the standard "
      "input. The command line overrides them");
  line.add_trust();
  line.begin_group(group_name(ParameterGroup::camera));
  line.add_value("--camera", camera_, "FILE[:NAME]",
                 "camera of a .gltf, .glb or ParaView's .pvcc; :NAME of one of several");
  line.add_parameters(settings_,
                      [&](const Parameter& p) { return std::ranges::count(without, p.name) == 0; });
}

std::vector<std::string> SceneOptions::notices() const {
  std::vector<std::string> notices;
  for (const Setting& setting : settings_)
    if (std::string notice = color_notice(*find_parameter(setting.name), setting.text);
        !notice.empty())
      notices.push_back(std::move(notice));
  return notices;
}

Scene SceneOptions::scene(Scene scene) {
  if (!file_.empty()) {
    SceneFile read = read_scene_file(file_);
    scene = std::move(read.scene);
    layers_ = std::move(read.layers);
  }
  scene = with_settings(std::move(scene), camera_, settings_, file_z_is_up);
  Scene given = scene;
  // the look may bring a surface
  if (leaves_look_open(scene) || !scene.look.empty()) given.isovalue.clear();
  validate(given);
  return scene;
}

void FrameOptions::add_to(CommandLine& line) {
  line.begin_group("Frames");
  line.add_value("IN.vdb", inputs, "",
                 "a volume; or a sequence: fire.####.vdb, a folder, or several files")
      ->take_all();
  line.add_value("--frames", frames, "A-B[xS]",
                 "frames of a sequence, such as 1-100, 1-100x2 or 1-10,20 (default: all)");
  line.add_value(
      "--auto-from", auto_from, "all|A-B[xS]",
      "frames from which extinction, camera, range, look and exposure are chosen for "
      "all (default: the first, the middle, the last, and those that burn most and hottest)");
  line.add_value("--missing", missing, "error|skip|hold",
                 "what to do about a frame without a file: refuse to start, leave it out, or take "
                 "the one before it")
      ->check(one_of<std::string>({"error", "skip", "hold"}))
      ->capture_default_str();
}

}  // namespace psivox
