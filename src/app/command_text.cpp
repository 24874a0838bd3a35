#include "app/command_text.h"

#include "psivox/look.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

std::string quoted(const std::string& word) {
  constexpr const char* plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./,:=+@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  return shell_word(word);
}

}  // namespace

std::string shell_word(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::vector<std::string> render_arguments(const Scene& scene, const std::string& output) {
  std::vector<Setting> settings;
  for (const Parameter& p : parameters())
    if (!p.positional && !has_default(scene, p))
      settings.push_back({p.name, parameter_text(scene, p)});
  // defaults that the command line would replace are named too
  Scene read;
  apply_over(read, settings);
  for (const Parameter& p : parameters())
    if (!p.positional && has_default(scene, p) && !has_default(read, p))
      settings.push_back({p.name, parameter_text(scene, p)});
  // the scene is what is shown: nothing is left to a look
  if (leaves_look_open(scene)) settings.push_back({"look", "plain"});
  const bool like_an_option = scene.input.starts_with('-');
  std::vector<std::string> arguments = {(like_an_option ? "./" : "") + scene.input,
                                        "--output=" + output};
  for (const auto& [name, text] : settings) arguments.push_back("--" + name + "=" + text);
  return arguments;
}

std::string render_command_line(const Scene& scene, const std::string& output) {
  std::string line = "psivox render";
  for (const std::string& word : render_arguments(scene, output)) line += " " + quoted(word);
  return line;
}

}  // namespace psivox
