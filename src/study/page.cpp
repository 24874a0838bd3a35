#include <unistd.h>

#include "base/html.h"
#include "base/text_file.h"
#include "psivox/image.h"
#include "study/page.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// The picture at most `width` pixels wide: means over blocks of pixels.
Image shrunk(const Image& image, int width) {
  const int block = (image.width + width - 1) / width;
  Image out;
  out.width = (image.width + block - 1) / block;
  out.height = (image.height + block - 1) / block;
  out.layers.push_back({"",
                        {"R", "G", "B", "A"},
                        std::vector<float>(std::size_t(out.width) * std::size_t(out.height) * 4)});
  std::vector<float> counts(out.layers[0].values.size());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 4; ++c) {
        const auto to = std::size_t((y / block * out.width + x / block) * 4 + c);
        out.rgba()[to] += image.rgba()[std::size_t(y * image.width + x) * 4 + std::size_t(c)];
        counts[to] += 1;
      }
  for (std::size_t i = 0; i < counts.size(); ++i) out.rgba()[i] /= counts[i];
  return out;
}

/// The bytes of the file, or of a smaller picture if the file's is more than `width` pixels wide.
std::string png_bytes(const fs::path& png, int width) {
  const Image image = read_image(png);
  if (image.width <= width) return read_text(png.string(), "picture");
  const fs::path small = png.parent_path() / (".small-" + std::to_string(getpid()) + ".png");
  write_image(shrunk(image, width), small);
  const std::string bytes = read_text(small.string(), "picture");
  fs::remove(small);
  return bytes;
}

}  // namespace

std::string html_page(const std::string& title, const std::string& body) {
  const auto script = [](const char* file) {
    return "<script>" + page_files().at(file) + "</script>\n";
  };
  const bool has_plots = body.find("class=\"plot\"") != std::string::npos;
  const std::string scripts = has_plots ? script("chart.min.js") + script("plots.js") : "";
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
         "name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         html_text(title) + "</title>\n<style>\n" + page_files().at("page.css") +
         "</style>\n</head>\n<body>\n<h1>" + html_text(title) + "</h1>\n" + body + scripts +
         "</body>\n</html>\n";
}

std::string html_table(const TextTable& rows, Cells cells) {
  std::string out = std::string("<div class=\"wide\"><table") +
                    (cells == Cells::words ? " class=\"words\"" : "") + ">\n";
  for (const auto& row : rows) {
    const char* cell = &row == &rows.front() ? "th" : "td";
    out += "<tr>";
    for (const std::string& text : row)
      out += std::string("<") + cell + ">" + text + "</" + cell + ">";
    out += "</tr>\n";
  }
  return out + "</table></div>\n";
}

std::string html_section(const std::string& title, const std::string& text, const TextTable& table,
                         Cells cells) {
  return "<h2>" + title + "</h2>\n<p>" + text + "</p>\n" + html_table(table, cells);
}

std::string html_figure(const fs::path& png, const std::string& caption, int width,
                        const std::string& variant) {
  std::string out = "<figure";
  if (!variant.empty()) out += " data-variant=\"" + html_text(variant) + "\"";
  out += ">";
  if (fs::exists(png))
    out += "<img alt=\"\" src=\"data:image/png;base64," + base64(png_bytes(png, width)) + "\">";
  return out + "<figcaption>" + caption + "</figcaption></figure>\n";
}

}  // namespace psivox
