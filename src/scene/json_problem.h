#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

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

}  // namespace psivox
