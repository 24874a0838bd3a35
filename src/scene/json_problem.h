#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "psivox/error.h"

namespace psivox {

/// Why a text could not be parsed: "line 3, column 5: expected '}'".
inline std::string json_problem(std::string_view text, const nlohmann::json::exception& error) {
  const auto* const fault = dynamic_cast<const nlohmann::json::parse_error*>(&error);
  if (!fault) return "a number is beyond double precision";
  const std::string_view before = text.substr(0, fault->byte > 0 ? fault->byte - 1 : 0);
  const auto line = 1 + std::ranges::count(before, '\n');
  const std::size_t column = before.size() - (before.rfind('\n') + 1) + 1;
  const std::string said = error.what();
  const std::size_t expected = said.rfind("; expected ");
  // an invalid token is quoted, whatever it holds
  const bool tells = expected != said.npos && said.find("last read: ") == said.npos;
  return "line " + std::to_string(line) + ", column " + std::to_string(column) +
         (tells ? ":" + said.substr(expected + 1) : " is not valid");
}

/// The JSON of a text. Functions may follow it by recursion: it is nested no deeper than the stack
/// bears. Throws an Error that begins with `where` if it is, and what Json::parse throws.
template <typename Json = nlohmann::json>
Json shallow_json(std::string_view text, const std::string& where, ExitCode code,
                  bool throws = true) {
  constexpr int deepest = 200;
  const auto check = [&](int depth, typename Json::parse_event_t, Json&) {
    if (depth > deepest)
      throw Error(code, where + ": it is nested deeper than " + std::to_string(deepest));
    return true;
  };
  return Json::parse(text, check, throws);
}

/// The JSON of a text. Throws an Error: "not a scene in JSON: line 3, ...", if `what` is a scene.
inline nlohmann::json parsed_json(std::string_view text, const std::string& what, ExitCode code) {
  try {
    return shallow_json(text, "not " + what, code);
  } catch (const nlohmann::json::exception& error) {
    throw Error(code, "not " + what + " in JSON: " + json_problem(text, error));
  }
}

/// Throws an Error if an object has a key that is not known.
inline void check_keys(const nlohmann::json& object, const std::vector<std::string>& known,
                       const std::string& where, ExitCode code) {
  for (const auto& [key, value] : object.items())
    if (std::ranges::count(known, key) == 0)
      throw Error(code, where + ": unknown key " + in_quotes(key) + suggestion(key, known));
}

}  // namespace psivox
