#include "study/page.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "base/text_file.h"
#include "image/formats.h"
#include "page/page_parts.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// The picture at most `width` pixels wide: means over blocks of pixels.
Image shrunk(const Image& image, int width) {
  const int block = (image.width + width - 1) / width;
  Image out = rgba_image((image.width + block - 1) / block, (image.height + block - 1) / block);
  std::vector<float> counts(out.rgba().size());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 4; ++c) {
        const std::size_t to = 4 * out.index(x / block, y / block) + std::size_t(c);
        out.rgba()[to] += image.rgba()[4 * image.index(x, y) + std::size_t(c)];
        counts[to] += 1;
      }
  for (std::size_t i = 0; i < counts.size(); ++i) out.rgba()[i] /= counts[i];
  return out;
}

/// The bytes of the file, or of a smaller picture if the file's is more than `width` pixels wide.
std::string png_bytes(const fs::path& png, int width) {
  const Image image = read_image(png);
  if (image.width <= width) return read_text(png.string(), "picture");
  return image_io::png_bytes(shrunk(image, width));
}

/// A whole page with its style, and with the scripts of its plots if it has any. No other script
/// runs there.
std::string html_page(const std::string& title, const Html& body) {
  std::vector<std::string> scripts;
  if (body.str().find("class=\"plot\"") != std::string::npos)
    scripts = {"chart.min.js", "plots.js"};
  Html elements;
  for (const std::string& script : scripts)
    elements += Html("<script>") + Html::of_markup(page_files().at(script)) + "</script>\n";
  return (Html("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
               "http-equiv=\"Content-Security-Policy\" content=\"") +
          Html::of_markup(content_policy(page_files(), scripts)) +
          "\">\n<meta "
          "name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
          title + "</title>\n<style>\n" + Html::of_markup(page_files().at("page.css")) +
          "</style>\n</head>\n<body>\n<h1>" + title + "</h1>\n" + body + elements +
          "</body>\n</html>\n")
      .str();
}

constexpr int least_width = 900, page_height = 560;
constexpr double letter_width = 6.5;  ///< approximate width of a letter of the legend
constexpr double left = 80, right = 690, top = 40, bottom = 500;  ///< the box of the axes
constexpr Ink black{20, 20, 20}, grey{225, 225, 225}, dark_grey{185, 185, 185};

/// A logarithmic axis: the values `first` and `last` are at `from` and `to` on the page.
struct Axis {
  double first, last, from, to;

  double at(double value) const {
    return from + (to - from) * std::log10(value / first) / std::log10(last / first);
  }

  struct Tick {
    double value;
    bool labelled;
  };
  /// Decades and their multiples. With few decades, multiples are labelled too.
  std::vector<Tick> ticks() const {
    const double decades = std::log10(last / first);
    const int stride = std::max(1, int(std::ceil(decades / 10)));
    std::vector<Tick> out;
    for (int power = int(std::floor(std::log10(first))); power <= int(std::ceil(std::log10(last)));
         ++power)
      for (int digit = 1; digit < 10; ++digit) {
        const double value = digit * std::pow(10.0, power);
        if (value < first * (1 - 1e-9) || value > last * (1 + 1e-9)) continue;
        const bool between =
            decades < 1 || (decades < 2.5 && (digit == 2 || digit == 3 || digit == 5));
        const bool labelled = digit == 1 ? power % stride == 0 : between;
        out.push_back({value, labelled});
      }
    return out;
  }
};

/// An axis with a margin around the values.
Axis make_axis(double least, double greatest, double from, double to) {
  if (!(least <= greatest)) least = 0.1, greatest = 10;  // no points
  const double margin = std::max(0.05 * std::log10(greatest / least), 0.1);
  return {least * std::pow(10, -margin), greatest * std::pow(10, margin), from, to};
}

/// 2, 0.5, 1e-3.
std::string tick_label(double value) {
  std::string text = two_digits(value);
  if (value >= 0.01 && value < 10000) return number_text(std::stod(text));
  const std::size_t zero = text.find(".0");
  return zero == std::string::npos ? text : text.erase(zero, 2);
}

class PlotPage {
 public:
  explicit PlotPage(const Plot& plot) : plot_(plot) {
    double x[2] = {HUGE_VAL, -HUGE_VAL}, y[2] = {HUGE_VAL, -HUGE_VAL};
    for (const Series& series : plot.series)
      for (const PlotPoint& point : series.points) {
        if (!has_place(point)) continue;
        x[0] = std::min(x[0], point.lower > 0 ? point.lower : point.x);
        x[1] = std::max({x[1], point.x, point.upper});
        y[0] = std::min(y[0], point.y), y[1] = std::max(y[1], point.y);
      }
    x_ = make_axis(x[0], x[1], left, right);
    y_ = make_axis(y[0], y[1], bottom, top);
    std::size_t letters = 0;
    for (const LegendEntry& entry : plot.legend) letters = std::max(letters, entry.text.size());
    width_ = std::max(least_width, int(right + 60 + letter_width * double(letters)));
  }

  std::string drawn() {
    axes();
    for (const Series& series : plot_.series) series.front ? front(series) : curve(series);
    legend();
    return formatted(R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 %d %d" width="%d" )"
                     R"(height="%d" font-family="sans-serif" font-size="12">)",
                     width_, page_height, width_, page_height) +
           "\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n" + elements_ + "</svg>\n";
  }

 private:
  /// `dash`: length of a dash and of the gap after it; 0: solid.
  void line(double x1, double y1, double x2, double y2, double width, Ink ink, double dash = 0) {
    elements_ += formatted(R"(<line x1="%.2f" y1="%.2f" x2="%.2f" y2="%.2f" stroke="%s")", x1, y1,
                           x2, y2, hex(ink).c_str()) +
                 formatted(R"( stroke-width="%.2f")", width) +
                 (dash > 0 ? formatted(R"( stroke-dasharray="%.2f")", dash) : "") + "/>\n";
  }

  void mark(double x, double y, double r, Shape shape, Ink ink) {
    const std::string color = hex(ink);
    std::string form;
    if (shape == Shape::disc || shape == Shape::ring)
      form = formatted(R"(<circle cx="%.2f" cy="%.2f" r="%.2f")", x, y, r);
    else if (shape == Shape::square)
      form = formatted(R"(<rect x="%.2f" y="%.2f" width="%.2f" height="%.2f")", x - r, y - r, 2 * r,
                       2 * r);
    else if (shape == Shape::triangle)
      form = formatted(R"(<polygon points="%.2f,%.2f %.2f,%.2f %.2f,%.2f")", x, y - r, x + r, y + r,
                       x - r, y + r);
    else
      form = formatted(R"(<polygon points="%.2f,%.2f %.2f,%.2f %.2f,%.2f %.2f,%.2f")", x, y - r,
                       x + r, y, x, y + r, x - r, y);
    elements_ += form + (shape == Shape::ring
                             ? " fill=\"none\" stroke=\"" + color + "\" stroke-width=\"1.5\"/>\n"
                             : " fill=\"" + color + "\"/>\n");
  }

  /// `anchor`: the part of the text that is at (x, y). `upwards`: it reads from bottom to top.
  void text(double x, double y, const std::string& words, const char* anchor,
            bool upwards = false) {
    elements_ += formatted(R"(<text x="%.2f" y="%.2f" text-anchor="%s" fill="%s")", x, y, anchor,
                           hex(black).c_str()) +
                 (upwards ? formatted(" transform=\"rotate(-90 %.2f %.2f)\"", x, y) : "") + ">" +
                 html_text(words) + "</text>\n";
  }

  void axes() {
    for (const auto& [value, labelled] : x_.ticks()) {
      const double x = x_.at(value);
      line(x, top, x, bottom, 1, labelled ? dark_grey : grey);
      if (labelled) text(x, bottom + 16, tick_label(value), "middle");
    }
    for (const auto& [value, labelled] : y_.ticks()) {
      const double y = y_.at(value);
      line(left, y, right, y, 1, labelled ? dark_grey : grey);
      if (labelled) text(left - 6, y + 4, tick_label(value), "end");
    }
    line(left, bottom, right, bottom, 1.5, black);
    line(left, top, left, bottom, 1.5, black);
    text((left + right) / 2, top - 14, plot_.title, "middle");
    text((left + right) / 2, bottom + 38, plot_.x_label, "middle");
    text(22, (top + bottom) / 2, plot_.y_label, "middle", true);
  }

  std::vector<std::pair<double, double>> places_of(const Series& series) const {
    std::vector<std::pair<double, double>> places;
    for (const PlotPoint& point : series.points)
      if (has_place(point)) places.emplace_back(x_.at(point.x), y_.at(point.y));
    return places;
  }

  void curve(const Series& series) {
    const auto places = places_of(series);
    for (std::size_t i = 1; i < places.size(); ++i)
      line(places[i - 1].first, places[i - 1].second, places[i].first, places[i].second, 1.4,
           series.ink, series.dashed ? 4 : 0);
    for (const auto& [x, y] : places) mark(x, y, mark_radius, series.shape, series.ink);
    for (const PlotPoint& p : series.points)
      if (has_place(p) && p.lower > 0 && p.lower < p.upper)
        line(x_.at(p.lower), y_.at(p.y), x_.at(p.upper), y_.at(p.y), 1, series.ink);
  }

  void front(const Series& series) {
    const auto places = places_of(series);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto [x, y] = places[i];
      mark(x, y, front_radius, series.shape, series.ink);
      if (i + 1 == places.size()) continue;
      const auto [next_x, next_y] = places[i + 1];
      line(x, y, next_x, y, 1, series.ink, 3);
      line(next_x, y, next_x, next_y, 1, series.ink, 3);
    }
  }

  void legend() {
    double y = top + 6;
    for (const LegendEntry& entry : plot_.legend) {
      if (entry.joined) line(right + 16, y, right + 44, y, 1.4, entry.ink, entry.dashed ? 4 : 0);
      mark(right + 30, y, entry.radius, entry.shape, entry.ink);
      text(right + 52, y + 4, entry.text, "start");
      y += 19;
    }
  }

  const Plot& plot_;
  Axis x_{}, y_{};
  int width_ = least_width;
  std::string elements_;
};

}  // namespace

std::string csv_text(const std::vector<Json>& rows, const std::string& head) {
  std::string out = head + "\n";
  for (const Json& row : rows) {
    std::vector<std::string> cells;
    for (const std::string& name : split(head)) {
      const Json value = row.value(name, Json());
      cells.push_back(value.is_string()   ? value.get<std::string>()
                      : value.is_number() ? number_text(value.get<double>())
                                          : "");
    }
    out += joined(cells) + "\n";
  }
  return out;
}

std::string csv_text(const std::vector<Json>& rows) {
  std::vector<std::string> names;
  for (const auto& [name, value] : rows.front().items()) names.push_back(name);
  return csv_text(rows, joined(names));
}

std::string markdown_table(const TextTable& rows) {
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

void set_cell(TextTable& table, const std::string& row, const std::string& column,
              const std::string& text) {
  const auto column_at = std::ranges::find(table.front(), column) - table.front().begin();
  if (std::size_t(column_at) == table.front().size()) {
    for (auto& cells : table) cells.emplace_back("–");
    table.front().back() = column;
  }
  auto own = std::ranges::find(table, row, [](const auto& cells) { return cells.front(); });
  if (own == table.end()) {
    own = table.insert(own, std::vector<std::string>(table.front().size(), "–"));
    own->front() = row;
  }
  (*own)[std::size_t(column_at)] = text;
}

Html html_table(const TextTable& rows, Cells cells) {
  Html out("<div class=\"wide\"><table");
  if (cells == Cells::words) out += " class=\"words\"";
  out += ">\n";
  for (const auto& row : rows) {
    const bool head = &row == &rows.front();
    out += "<tr>";
    for (const std::string& text : row)
      out += head ? Html("<th>") + text + "</th>" : Html("<td>") + text + "</td>";
    out += "</tr>\n";
  }
  return out + "</table></div>\n";
}

void write_sections(const fs::path& folder, const std::string& name, const std::string& title,
                    const std::vector<Section>& sections) {
  std::string markdown;
  Html page;
  for (const Section& s : sections) {
    if (s.table.size() == 1) continue;
    if (!s.title.empty()) page += Html("<h2>") + s.title + "</h2>\n";
    if (!s.text.empty()) page += Html("<p>") + s.text + "</p>\n";
    page += s.html;
    if (!s.table.empty()) page += html_table(s.table, s.cells);
    markdown += s.markdown;
    if (s.text.empty() && s.table.empty()) continue;
    if (!s.title.empty()) markdown += "**" + s.title + "**\n\n";
    if (!s.text.empty()) markdown += s.text + "\n\n";
    if (!s.table.empty()) markdown += markdown_table(s.table) + "\n";
  }
  write_text((folder / (name + ".md")).string(), markdown);
  write_text((folder / page_name).string(), html_page(title, page));
}

Html html_figure(const fs::path& png, const Html& caption, int width, const std::string& variant) {
  Html out("<figure");
  if (!variant.empty()) out += Html(" data-variant=\"") + variant + "\"";
  out += ">";
  if (fs::exists(png))
    out +=
        Html("<img alt=\"\" src=\"data:image/png;base64,") + base64(png_bytes(png, width)) + "\">";
  return out + "<figcaption>" + caption + "</figcaption></figure>\n";
}

std::string hex(Ink ink) { return formatted("#%02x%02x%02x", ink.r, ink.g, ink.b); }

bool has_place(const PlotPoint& point) {
  return point.x > 0 && point.y > 0 && std::isfinite(point.x) && std::isfinite(point.y);
}

std::string svg_of(const Plot& plot) { return PlotPage(plot).drawn(); }

}  // namespace psivox
