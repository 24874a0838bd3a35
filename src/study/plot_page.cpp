// A plot on a page: data for src/study/page/plots.js.

#include "study/plot_page.h"

#include <nlohmann/json.hpp>

#include "psivox/text_file.h"
#include "study/html.h"

namespace psivox {
namespace {

using Json = nlohmann::ordered_json;

const char* shape_name(Shape shape) {
  constexpr const char* names[] = {"disc", "square", "diamond", "ring"};
  return names[static_cast<int>(shape)];
}

Json json_of(const Series& series) {
  Json out = {{"entries", series.entries},
              {"color", hex(series.ink)},
              {"shape", shape_name(series.shape)},
              {"dashed", series.dashed},
              {"points", Json::array()}};
  for (const PlotPoint& point : series.points)
    if (has_place(point)) out["points"].push_back({point.x, point.y, point.name});
  return out;
}

Json json_of(const LegendEntry& entry) {
  return {{"text", entry.text},
          {"color", hex(entry.ink)},
          {"shape", shape_name(entry.shape)},
          {"joined", entry.joined},
          {"dashed", entry.dashed}};
}

Json json_of(const Plot& plot) {
  Json out = {{"title", plot.title},
              {"x", plot.x_label},
              {"y", plot.y_label},
              {"legend", Json::array()},
              {"series", Json::array()}};
  for (const LegendEntry& entry : plot.legend) out["legend"].push_back(json_of(entry));
  for (const Series& series : plot.series) out["series"].push_back(json_of(series));
  if (!plot.front.empty()) {
    out["series"].push_back(json_of(front_series(plot)));
    out["series"].back()["front"] = true;
  }
  return out;
}

/// JSON inside HTML. It must not contain `<`, because `</script>` would end it.
std::string html_json(const std::string& attributes, const Json& data) {
  std::string text;
  for (const char c : data.dump(-1, ' ', false, Json::error_handler_t::replace))
    text += c == '<' ? "\\u003c" : std::string(1, c);
  return "<script type=\"application/json\"" + attributes + ">" + text + "</script>\n";
}

}  // namespace

std::string write_plot(const NamedPlot& named, const std::filesystem::path& folder) {
  const std::string svg = svg_of(named.plot), file = named.name + ".svg";
  write_text((folder / file).string(), svg);
  return "<section class=\"plot\" id=\"" + named.name + "\"><header><h3>" +
         escaped(named.plot.title) + "</h3><a href=\"" + file + "\">SVG</a></header>\n" + svg +
         html_json("", json_of(named.plot)) + "</section>\n";
}

std::string html_facts(const std::map<std::string, Facts>& facts) {
  return html_json(" id=\"facts\"", facts);
}

}  // namespace psivox
