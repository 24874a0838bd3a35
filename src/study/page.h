#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/text.h"
#include "psivox/error.h"

namespace psivox {

/// Two significant digits, such as 1.3e-6; 0 is "0".
inline std::string two_digits(double value) {
  if (value == 0) return "0";
  const std::string out = formatted("%.1e", value);
  const std::size_t e = out.find('e');
  if (e == std::string::npos) return out;  // inf, nan
  const int power = std::stoi(out.substr(e + 1));
  return power ? out.substr(0, e + 1) + std::to_string(power) : out.substr(0, e);
}

inline std::string decimals(double value, int count) { return formatted("%.*f", count, value); }

/// Rows of cells; the first row is the head.
using TextTable = std::vector<std::vector<std::string>>;

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

/// Names and texts: cells of a row, or what describes a point.
using Facts = std::vector<std::pair<std::string, std::string>>;

/// Builds a line of CSV. It quotes nothing: no name in a study has a comma or a quote.
class CsvLine {
 public:
  CsvLine& operator<<(const std::string& text) {
    text_ += (text_.empty() ? "" : ",") + text;
    return *this;
  }
  CsvLine& operator<<(double value) { return *this << number_text(value); }
  std::string str() const { return text_ + "\n"; }

 private:
  std::string text_;
};

/// A whole page with its style, and with the scripts of its plots if it has any. `title` is text,
/// `body` is HTML.
std::string html_page(const std::string& title, const std::string& body);

/// The first row is the head. Cells are HTML: words are left-aligned and wrap, numbers are
/// right-aligned.
enum class Cells { numbers, words };
std::string html_table(const TextTable& rows, Cells cells = Cells::numbers);

/// A heading, a text in HTML and a table.
std::string html_section(const std::string& title, const std::string& text, const TextTable& table,
                         Cells cells = Cells::numbers);

/// A PNG inside the page, at most `width` pixels wide, above a line of HTML; the line alone if
/// there is no such file. Plots show the figure beside the points with the name `variant`.
std::string html_figure(const std::filesystem::path& png, const std::string& caption, int width,
                        const std::string& variant = "");

/// Makes the folder and its parents. Throws Error(output).
inline void make_folder(const std::filesystem::path& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure || !std::filesystem::is_directory(folder))
    throw Error(ExitCode::output, "cannot make the folder " + in_quotes(folder.string()) +
                                      (failure ? ": " + failure.message() : ""));
}

/// Texts that a page contains, by file name: page.css and plots.js from src/study/page, and
/// Chart.js as chart.min.js.
const std::map<std::string, std::string>& page_files();

}  // namespace psivox
