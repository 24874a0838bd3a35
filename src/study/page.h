#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "study/results.h"

// What studies write: tables, plots and pages.

namespace psivox {

/// The commit that was built; empty without git.
const char* git_hash();

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

/// HTML in which no text becomes markup: literals stand as they are, all other text is escaped.
class Html {
 public:
  Html() = default;
  template <std::size_t size>
  Html(const char (&markup)[size]) : html_(markup) {}
  Html(const std::string& text) : html_(html_text(text)) {}
  /// Of psivox's own making, such as an SVG.
  static Html of_markup(std::string markup) {
    Html html;
    html.html_ = std::move(markup);
    return html;
  }
  Html& operator+=(const Html& more) {
    html_ += more.html_;
    return *this;
  }
  friend Html operator+(Html begin, const Html& end) { return begin += end; }
  const std::string& str() const { return html_; }

 private:
  std::string html_;
};

/// Rows of cells; the first row is the head.
using TextTable = std::vector<std::vector<std::string>>;

/// Names and texts that describe a point.
using Facts = std::vector<std::pair<std::string, std::string>>;

using Json = nlohmann::ordered_json;

/// CSV of rows of values by name: the line `head` of names with commas, and below it each row's
/// numbers, with all their digits, and texts, which have neither comma nor quote. A value that a
/// row lacks, or that is null, is empty.
std::string csv_text(const std::vector<Json>& rows, const std::string& head);
/// The head has the names of the first row.
std::string csv_text(const std::vector<Json>& rows);

/// Cells of words are left-aligned and wrap, numbers are right-aligned.
enum class Cells { numbers, words };
Html html_table(const TextTable& rows, Cells cells = Cells::numbers);
std::string markdown_table(const TextTable& rows);
/// Sets a cell by the names of its row and its column, which stand in the first column and the
/// first row. Adds the row or column if the table lacks it. A cell that is never set is "–".
void set_cell(TextTable& table, const std::string& row, const std::string& column,
              const std::string& text);

/// A part of a study's report.
struct Section {
  std::string title{};
  std::string text{};
  TextTable table{};
  Cells cells = Cells::numbers;
  Html html{};             ///< between text and table, on the page alone
  std::string markdown{};  ///< before the text, in Markdown alone
};

/// Writes the sections to NAME.md and, as a page of that title, to index.html. It leaves out those
/// whose table has a head alone.
void write_sections(const std::filesystem::path& folder, const std::string& name,
                    const std::string& title, const std::vector<Section>& sections);

/// A PNG inside the page, at most `width` pixels wide, above a caption; the caption alone if there
/// is no such file. Plots show the figure beside the points with the name `variant`.
Html html_figure(const std::filesystem::path& png, const Html& caption, int width,
                 const std::string& variant = "");

inline constexpr const char* page_name = "index.html";

/// The folder of a study that begins or, to `resume`, goes on. Throws as check_study_folder does.
WrittenFolder study_folder(const std::filesystem::path& folder, bool resume);

/// Texts that a page contains, by file name: page.css and plots.js from src/study/page, and
/// Chart.js as chart.min.js.
const std::map<std::string, std::string>& page_files();

/// An sRGB colour.
struct Ink {
  std::uint8_t r = 0, g = 0, b = 0;
};
/// "#1f77b4", as HTML and SVG write it.
std::string hex(Ink ink);

enum class Shape { disc, square, diamond, ring, triangle };

struct PlotPoint {
  double x = 0, y = 0;
  std::string name{};           ///< shown by an interactive plot; may be empty
  double lower = 0, upper = 0;  ///< quartiles of x, joined by a line; 0: none
};

/// Whether a logarithmic plot can show the point: both numbers must be finite and above 0.
bool has_place(const PlotPoint& point);

/// Points joined in their order.
struct Series {
  std::vector<PlotPoint> points;
  Ink ink;
  Shape shape = Shape::disc;
  bool dashed = false;
  std::vector<std::string> entries{};  ///< its texts in the legend
  bool front = false;                  ///< a Pareto front: marked by rings, and joined by steps
};

/// Radii of marks, and of the rings of the front around them [pixels].
constexpr double mark_radius = 3.5, front_radius = 7;

/// A line of the legend: a mark, and a line through it if `joined`.
struct LegendEntry {
  std::string text;
  Ink ink;
  Shape shape = Shape::disc;
  bool joined = false, dashed = false;
  double radius = mark_radius;
};

/// A plot with two logarithmic axes. It leaves out points that these cannot show.
struct Plot {
  std::string title, x_label, y_label;
  std::vector<Series> series;
  std::vector<LegendEntry> legend;
  std::string name{};  ///< of its file
};

std::string svg_of(const Plot& plot);

/// The Pareto front of costs x and errors y, by cost. A point joins the front if its error is less
/// than (1 - margin) times the least error of the cheaper points.
std::vector<PlotPoint> pareto_front(std::vector<PlotPoint> points, double margin = 0);

/// Writes the plot as NAME.svg to the folder. Returns HTML: the SVG, and the plot's data for the
/// interactive chart that replaces the SVG where scripts run.
Html write_plot(const Plot& plot, const std::filesystem::path& folder);

/// HTML of the facts that charts show beside points, by the points' names. Once per page.
Html html_facts(const std::map<std::string, Facts>& facts);

/// The points of one rule and sampling, joined in their order.
struct PlotCurve {
  Variant variant;
  std::vector<PlotPoint> points;
};

/// Curves in the rules' colours and with the samplings' marks, and a legend. Titles are left empty.
Plot plot_of_curves(const std::vector<PlotCurve>& curves);

/// The rule's colour in every plot.
Ink ink_of(Integrator rule);

/// If a software renderer's wall times scatter between repeats and its processor times do not: a
/// sentence that says so; then the page plots processor time alone. Else empty.
std::string clock_note(const StudyResults& results);

/// Plots of error by step, by look-ups, by GPU time if the driver has a timer, and by CPU time.
std::vector<Plot> plots_of(const StudyResults& results);

/// RMS by look-ups per ray: geometric means over the studies, at every RMS that all of them reach.
Plot look_ups_plot(const std::vector<StudyResults>& studies);

}  // namespace psivox
