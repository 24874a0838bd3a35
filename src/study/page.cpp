#include "study/page.h"

#include <algorithm>

#include "image/formats.h"
#include "page/page_parts.h"
#include "psivox/image.h"
#include "psivox/integrators.h"

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

}  // namespace

std::string two_digits(double value) {
  if (value == 0) return "0";
  const std::string out = formatted("%.1e", value);
  const std::size_t e = out.find('e');
  if (e == std::string::npos) return out;  // inf, nan
  const int power = std::stoi(out.substr(e + 1));
  return power ? out.substr(0, e + 1) + std::to_string(power) : out.substr(0, e);
}

std::string json_text(const Json& json) {
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string csv_text(const std::vector<Json>& rows, std::string head) {
  if (head.empty() && !rows.empty())
    for (const auto& [name, value] : rows.front().items()) head += (head.empty() ? "" : ",") + name;
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

Json rules_json() {
  Json rules = Json::array();
  for (const IntegratorInfo& rule : integrators) {
    std::string name = rule.name;
    std::ranges::replace(name, '_', '-');
    rules.push_back({{"name", name}, {"help", rule.help}});
  }
  return rules;
}

void write_page(const fs::path& folder, const std::string& title, const std::string& data,
                const std::vector<PagePicture>& pictures, const std::vector<std::string>& links) {
  Json files = {{"pictures", Json::object()}, {"links", Json::array()}};
  for (const auto& [file, width] : pictures)
    if (fs::exists(folder / file))
      files["pictures"][file] = base64(png_bytes(folder / file, width));
  for (const std::string& link : links)
    if (fs::exists(folder / link)) files["links"].push_back(link);
  const std::string listed = files.dump(-1, ' ', false, Json::error_handler_t::replace);
  const std::string page = filled_page(page_files(), {"plots.js", "page.js"},
                                       {{"@DATA@", without_tags(data)},
                                        {"@FILES@", without_tags(listed)},
                                        {"@HEADING@", html_text(title)},
                                        {"@STYLE@", page_files().at("page.css")},
                                        {"@TITLE@", html_text(title)}});
  write_text((folder / page_name).string(), page);
}

}  // namespace psivox
