// What the precision suite writes: suite.json, suite.csv and the page.

#include <algorithm>

#include "psivox/error.h"
#include "study/page.h"
#include "study/suite.h"

namespace psivox {
namespace {

Json json_of(const OrderRow& row) {
  return {{"way", row.way},
          {"expected", row.expected},
          {"order", row.is_measured() ? Json(row.observed()) : Json()},
          {"verdict", !row.is_measured() ? "too few errors above rounding"
                      : row.holds()      ? "as expected"
                                         : "NOT AS EXPECTED"}};
}

Json json_of(const SuiteRow& row) {
  Json json = json_of(row.point);
  json.update({{"p999", row.p999},
               {"max", row.max},
               {"psnr", row.psnr()},
               {"rays", row.rays},
               {"above", row.above}});
  return json;
}

Json json_of(const SuiteResult& r) {
  const Medium& medium = r.scene.views.front().medium;
  Json json = {{"name", r.scene.name},
               {"medium", r.scene.medium},
               {"function", medium.gradient   ? Json("gradient")
                            : medium.transfer ? Json("value")
                                              : Json()},
               {"reference_bound", r.reference_bound},
               {"orders", Json::array()},
               {"points", Json::array()}};
  for (const OrderRow& row : r.orders)
    if (row.expected > 0 || row.is_measured()) json["orders"].push_back(json_of(row));
  for (const SuiteRow& row : r.rows) json["points"].push_back(json_of(row));
  return json;
}

std::string suite_csv(const Json& scenes) {
  std::vector<Json> rows;
  for (const Json& scene : scenes)
    for (const Json& point : scene.at("points")) {
      Json row = {{"scene", scene.at("name")}};
      for (const char* name : {"rule", "setting", "step", "segments"}) row[name] = point.at(name);
      row["rms"] = point.at("error").at("rms");
      for (const char* name : {"p999", "max", "psnr", "rays", "samples_per_ray", "steps_per_ray"})
        row[name] = point.at(name);
      row["cpu_ms"] = point.at("times_ms").front().at("cpu");
      for (int bin = 1; bin <= suite_bins; ++bin)
        row["above_1e-" + std::to_string(bin)] = point.at("above").at(std::size_t(bin - 1));
      row["expected_order"] = row["order"] = Json();
      for (const Json& order : scene.at("orders"))
        if (order.at("way") == point.at("curve") && !order.at("order").is_null()) {
          row["order"] = order.at("order");
          if (order.at("expected") > 0) row["expected_order"] = order.at("expected");
        }
      rows.push_back(std::move(row));
    }
  return csv_text(rows);
}

}  // namespace

std::string write_suite(const std::vector<SuiteResult>& results, const std::string& renderer,
                        const std::filesystem::path& folder) {
  std::vector<std::string> misses;
  std::vector<PagePicture> pictures;
  std::size_t rows = 0;
  std::ptrdiff_t orders = 0;
  Json data = {{"psivox_suite", 1},    {"version", PSIVOX_VERSION}, {"git", git_hash()},
               {"renderer", renderer}, {"rules", rules_json()},     {"scenes", Json::array()}};
  for (const SuiteResult& r : results) {
    std::ranges::copy(r.misses(), std::back_inserter(misses));
    rows += r.rows.size();
    orders += std::ranges::count_if(r.orders, &OrderRow::is_held);
    data["scenes"].push_back(json_of(r));
    pictures.push_back({r.scene.name + ".png", 160});
  }
  const std::string conclusion =
      std::to_string(results.size()) + " scenes, " + std::to_string(rows) + " pictures, " +
      std::to_string(orders) + " orders of convergence held: " +
      (misses.empty() ? "all as expected" : std::to_string(misses.size()) + " not as expected") +
      ".";
  data["conclusion"] = conclusion;
  data["misses"] = misses;
  write_text((folder / "suite.csv").string(), suite_csv(data["scenes"]));
  write_text((folder / "suite.json").string(), json_text(data));
  write_page(folder, "psivox study --suite", json_text(data), pictures);
  if (!misses.empty()) throw Error(ExitCode::verification, joined(misses, "; "));
  return conclusion;
}

}  // namespace psivox
