#pragma once

#include <string>
#include <vector>

namespace psivox {

/// Rows of cells; the first row is the head.
using TextTable = std::vector<std::vector<std::string>>;

/// The table in Markdown.
inline std::string markdown_table(const TextTable& rows) {
  std::string out;
  for (const auto& row : rows) {
    for (const std::string& cell : row) out += "| " + cell + " ";
    out += "|\n";
    if (&row != &rows.front()) continue;
    for (std::size_t i = 0; i < row.size(); ++i) out += "|---";
    out += "|\n";
  }
  return out;
}

}  // namespace psivox
