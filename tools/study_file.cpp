#include "study_file.h"

#include <nlohmann/json.hpp>

#include "psivox/error.h"
#include "psivox/parameters.h"
#include "psivox/text.h"
#include "psivox/text_file.h"

namespace psivox {
namespace {

using nlohmann::json;

/// A list in the command line's syntax.
std::string list_text(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const json& item : value)
    text += (text.empty() ? "" : ",") + (item.is_string() ? item.get<std::string>() : item.dump());
  return text;
}

int repeats_of(const json& value) {
  if (!value.is_number_integer() || !repeats_range.contains(value.get<double>()))
    throw Error(ExitCode::usage,
                "repeats " + value.dump() + ": expected a whole number" + repeats_range.text());
  return value.get<int>();
}

}  // namespace

StudyFile read_study_file(const std::string& path) {
  const auto fail = [&](const std::string& what) {
    throw Error(ExitCode::usage, path + ": " + what);
  };
  json object;
  try {
    object = json::parse(read_text(path, "study"));
  } catch (const json::exception& error) {
    fail("not a study in JSON: " + std::string(error.what()));
  }
  if (!object.is_object()) fail("not a study: expected a JSON object");
  StudyFile file;
  for (const auto& [name, value] : object.items()) {
    try {
      if (name == "scene")
        file.scene = scene_from_json(value.dump(), "scene");
      else if (name == "repeats")
        file.repeats = repeats_of(value);
      else
        set_sweep(file.sweep, name, list_text(value));
    } catch (const Error& error) {
      fail(error.what());
    }
  }
  return file;
}

}  // namespace psivox
