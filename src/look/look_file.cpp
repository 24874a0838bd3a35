#include "look/look_file.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "look/choices.h"
#include "look/embedded_looks.h"
#include "psivox/error.h"
#include "psivox/look.h"
#include "psivox/parameters.h"
#include "psivox/text.h"
#include "psivox/text_file.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

bool is_path(const std::string& name) {
  return name.find('/') != std::string::npos || name.ends_with(".json");
}

/// Where a studio has its looks.
std::vector<std::string> studio_folders() {
  const char* folders = std::getenv("PSIVOX_LOOKS");
  return folders ? split(folders, ':') : std::vector<std::string>();
}

/// The file of that name in those folders.
std::optional<std::string> studio_look(const std::string& name) {
  for (const std::string& folder : studio_folders()) {
    const fs::path path = fs::path(folder) / (name + ".json");
    std::error_code missing;
    if (fs::exists(path, missing)) return path.string();
  }
  return {};
}

LookFile parsed(const std::string& text, const std::string& source) {
  const auto fail = [&](const std::string& what) {
    throw Error(ExitCode::usage, in_quotes(source) + ": " + what);
  };
  nlohmann::json look = nlohmann::json::parse(text, nullptr, false);
  if (!look.is_object()) fail("not a look: expected a JSON object of scene parameters");
  LookFile file;
  if (const auto choose = look.find("choose"); choose != look.end()) {
    if (!choose->is_array()) fail("choose: expected a list of names");
    for (const nlohmann::json& item : *choose) {
      const std::string name = item.is_string() ? item.get<std::string>() : item.dump();
      if (const auto known = choice_names(); std::ranges::find(known, name) == known.end())
        fail("choose: " + in_quotes(name) + " is none of " + joined(known, ", "));
      file.choices.push_back(name);
    }
    look.erase(choose);
  }
  for (const char* name : {"input", "look"})
    if (look.contains(name)) fail(std::string(name) + " has no place in a look");
  file.scene = scene_from_json(look.dump(), source);
  return file;
}

}  // namespace

std::vector<std::string> look_names() {
  std::vector<std::string> names{"plain"};
  for (const auto& [name, text] : embedded_looks()) names.push_back(name.substr(0, name.find('.')));
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> available_looks() {
  std::vector<std::string> names = look_names();
  for (const std::string& folder : studio_folders()) {
    std::error_code unreadable;
    for (const auto& entry : fs::directory_iterator(folder, unreadable))
      if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

LookFile read_look(const std::string& name) {
  if (name == "plain") return {};
  if (is_path(name)) return parsed(read_text(name, "look"), name);
  if (const auto path = studio_look(name)) return parsed(read_text(*path, "look"), *path);
  for (const auto& [file, text] : embedded_looks())
    if (file == name + ".json") return parsed(std::string(text), file);
  const std::vector<std::string> names = available_looks();
  throw Error(ExitCode::usage, "--look " + in_quotes(name) + ": no such look; there are auto, " +
                                   joined(names, ", ") +
                                   ", the path of a .json, and those in the folders of "
                                   "PSIVOX_LOOKS" +
                                   suggestion(name, names));
}

}  // namespace psivox
