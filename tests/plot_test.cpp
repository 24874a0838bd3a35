// Plots of a study as SVG, and the data that its page holds of them.

#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "base/text_file.h"
#include "study/page.h"
#include "thrown.h"

namespace psivox {
namespace {

TEST(Plot, PointsLieWhereTheirLogarithmsSay) {
  // Three decades of x, evenly: the marks are evenly spaced. Points not above 0 are left out.
  Plot plot;
  plot.series.push_back({{{1, 1e-3}, {10, 1e-4}, {100, 1e-5}, {0, 1}, {1, 0}}, Ink{9, 9, 9}});
  std::vector<glm::dvec2> marks;
  const std::string svg = svg_of(plot);
  const std::regex circle("<circle cx=\"([0-9.]+)\" cy=\"([0-9.]+)\"");
  for (std::sregex_iterator at(svg.begin(), svg.end(), circle), end; at != end; ++at)
    marks.emplace_back(std::stod((*at)[1]), std::stod((*at)[2]));
  ASSERT_EQ(marks.size(), 3u);
  constexpr double rounding = 0.01;  // of numbers written with two decimals
  EXPECT_NEAR(marks[1].x - marks[0].x, marks[2].x - marks[1].x, 2 * rounding);
  EXPECT_NEAR(marks[1].y - marks[0].y, marks[2].y - marks[1].y, 2 * rounding);
  EXPECT_GT(marks[1].x, marks[0].x);
  EXPECT_GT(marks[1].y, marks[0].y);  // downwards: smaller
}

TEST(Plot, SvgHasItsColoursAndText) {
  const Plot plot{
      .title = "a < b",
      .x_label = "x",
      .y_label = "y",
      .series = {{{{1, 1}, {2, 2}}, {255, 0, 0}}, {{{1, 2}}, {0, 0, 255}, Shape::square}},
      .legend = {}};
  const std::string page = svg_of(plot);
  for (const char* part : {"stroke=\"#ff0000\"", "fill=\"#0000ff\"", ">a &lt; b<", "</svg>"})
    EXPECT_TRUE(has(page, part));
}

TEST(Plot, PageHoldsItsData) {
  Plot plot;
  plot.name = "name";
  plot.title = "a < b";
  plot.series.push_back({{{1, 0.5, "</script>"}, {2, 0.25, "b", 1.5, 4}, {0, 1, "no place"}},
                         Ink{31, 119, 180},
                         Shape::square,
                         true,
                         {"rule", "cells"}});
  plot.legend.push_back({"rule", Ink{31, 119, 180}});
  plot.series.push_back(
      {{{2, 0.25, "b"}}, Ink{200, 0, 0}, Shape::ring, true, {"Pareto front"}, /*front=*/true});
  const std::filesystem::path folder = testing::TempDir();
  const std::string html = write_plot(plot, folder).str();
  EXPECT_TRUE(has(html, "<h3>a &lt; b</h3><a href=\"name.svg\">"));
  EXPECT_TRUE(has(html, read_text((folder / "name.svg").string(), "plot")));

  const std::string open = "<script type=\"application/json\">", close = "</script>";
  const std::size_t begin = html.find(open) + open.size();
  const std::string text = html.substr(begin, html.find(close, begin) - begin);
  EXPECT_TRUE(has(text, "[[1.0,0.5,\"\\u003c/script>\"],[2.0,0.25,\"b\",1.5,4.0]]"));
  for (const char* part : {R"("title":"a \u003c b")", R"("entries":["rule","cells"])",
                           R"("color":"#1f77b4")", R"("shape":"square")", R"("dashed":true)",
                           R"("entries":["Pareto front"])", R"("front":true)"})
    EXPECT_TRUE(has(text, part));
}

}  // namespace
}  // namespace psivox
