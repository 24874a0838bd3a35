#include "study/report.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "base/text.h"
#include "psivox/parameters.h"
#include "study/page.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;
constexpr int thumbnail_width = 256, picture_width = 512;

/// What shines on the scene: lights and sky.
std::string lights_text(const Scene& scene) {
  std::vector<std::string> lights;
  if (!scene.lights.empty()) lights.push_back(parameter_text(scene, "light"));
  if (scene.sky) lights.push_back("sky " + parameter_text(scene, "sky"));
  if (!scene.environment.empty()) lights.push_back("environment " + in_quotes(scene.environment));
  return lights.empty() ? "none" : joined(lights, "; ");
}

std::string light_text(const Scene& scene) {
  if (scene.shows(Shows::surface))
    return "shades the surface: " + lights_text(scene) + "; a fifth of white from everywhere";
  if (!scene.lit()) return "none";
  return lights_text(scene) +
         "; scattered once. A ray in double from each voxel to each light, once for the reference "
         "and all pictures: its error is the rounding to float32, and is in no number below" +
         (scene.sky || !scene.environment.empty() ? ". The sky is 512 directions" : "");
}

std::string luminance_text(const Scene& scene) {
  if (scene.shows(Shows::surface))
    return parameter_text(scene, "luminance") + ", the surface's colour";
  if (!scene.composites()) return "none under --mode " + parameter_text(scene, "mode");
  std::string luminance = parameter_text(scene, "luminance");
  if (!scene.luminance_grid.empty())
    luminance += " times " + parameter_text(scene, "luminance-scale") + " of " +
                 in_quotes(scene.luminance_grid);
  if (!scene.temperature_grid.empty())
    luminance += " times a black body's, of " + in_quotes(scene.temperature_grid);
  if (scene.colormap) luminance += " times the colours of " + parameter_text(scene, "colormap");
  if (!scene.transfer_function.empty())
    luminance += " times the colours of " + scene.transfer_function;
  return luminance;
}

std::string emission_text(const Scene& scene) {
  std::vector<std::string> grids;
  for (const EmissionOptions& emission : emission_options) {
    if ((scene.*emission.grid).empty() || !scene.composites()) continue;
    const bool hot = scene.*emission.color == EmissionColor::black_body;
    grids.push_back(number_text(scene.*emission.scale) + " times " +
                    in_quotes(scene.*emission.grid) + (hot ? ", a black body's" : ""));
  }
  return grids.empty() ? "none" : joined(grids, " and ");
}

Html head(const StudyResults& r) {
  const std::string version = r.version + (r.git.empty() ? "" : " (" + r.git + ")");
  const Scene scene = scene_in(r);
  return html_table(
      {{"study", ""},
       {"file", r.input + ", SHA-256 " + r.input_hash},
       {"date", r.date},
       {"light", light_text(scene)},
       {"luminance", luminance_text(scene)},
       {"emission", emission_text(scene)},
       {"reference", "adaptive quadrature in double; its error is at most " +
                         two_digits(r.reference_bound) + " at any pixel"},
       {"points", std::to_string(r.points.size()) + ", each timed " +
                      (r.repeats == 1 ? "once" : std::to_string(r.repeats) + " times")},
       {"psivox", version},
       {"GL", r.renderer},
       {"machine", r.processor + ", " + std::to_string(r.threads) + " threads, " + r.system}},
      Cells::words);
}

/// A command in elements, between which its lines break: between its options.
Html in_elements(const std::string& command, const Html& begin, const Html& end) {
  Html html = begin;
  std::size_t from = 0;
  for (std::size_t at; (at = command.find(" --", from)) != command.npos; from = at + 1)
    html += Html(command.substr(from, at - from)) + end + " " + begin;
  return html + command.substr(from) + end;
}

Html conclusion_html(const StudyResults& results) {
  Html html("<p class=\"conclusion\">");
  const std::vector<std::string> parts = split(conclusion_text(results), '`');
  for (std::size_t i = 0; i < parts.size(); ++i)
    html += i % 2 ? in_elements(parts[i], "<code>", "</code>") : Html(parts[i]);
  return html + "</p>\n";
}

/// How a paper names the study.
std::string citation(const StudyResults& r) {
  return "psivox " + r.version + (r.git.empty() ? "" : " (" + r.git + ")") + ", study of " +
         fs::path(r.input).filename().string() + ", " + r.date;
}

/// What each of the study's rules is, and the paper it is from.
Html rule_list(const StudyResults& results) {
  Html html("<ul>\n");
  for (const IntegratorInfo& rule : integrators) {
    const auto is_its = [&](const StudyPoint& p) {
      return !p.variant.tolerance && p.variant.method.integrator == rule.id;
    };
    if (std::ranges::none_of(results.points, is_its)) continue;
    const RuleSource source = source_of(rule.id);
    html += Html("<li>") + rule_name({{.integrator = rule.id}}) + ": " + std::string(rule.help) +
            " (<a href=\"https://doi.org/" + std::string(source.doi) + "\">" +
            std::string(source.paper) + "</a>)</li>\n";
  }
  return html + "</ul>\n";
}

/// The first screen: what was found, and of what.
Html first_screen(const StudyResults& results, const Html& pictures) {
  return conclusion_html(results) + "<div class=\"first\">\n<div>" + pictures +
         "</div>\n<div>\n<p>This command draws this picture; append a setting's options to draw it "
         "that way:</p>\n" +
         Html("<pre class=\"command\">") + in_elements(command_of(results), "<span>", "</span>") +
         "</pre>\n" + head(results) + "</div>\n</div>\n<p>" + std::string(eight_bits_note) +
         "</p>\n";
}

std::string spread_text(const Spread& s) {
  if (s.max <= 0) return "–";
  return decimals(s.median, 1) + " (" + decimals(s.lower, 1) + "–" + decimals(s.upper, 1) + ")";
}

std::string max_text(const Deviation& d) {
  return two_digits(d.max) + " at " + std::to_string(d.max_x) + "," + std::to_string(d.max_y);
}

/// A point's row in the table of all numbers.
Facts facts_of(const StudyPoint& p) {
  const auto rms = [](const std::optional<PictureError>& error) {
    return error ? two_digits(error->rms()) : "–";
  };
  Facts facts = {{"RMS", two_digits(p.rms())}};
  for (const auto& [channels, d] :
       {std::pair("radiance", &p.error.radiance), std::pair("alpha", &p.error.alpha)}) {
    const std::string prefix = channels + std::string(" ");
    facts.insert(facts.end(), {{prefix + "RMS", two_digits(d->rms)},
                               {prefix + "max, pixel", max_text(*d)},
                               {prefix + "99 %", two_digits(d->p99)},
                               {prefix + "mean", two_digits(d->mean)}});
  }
  facts.insert(facts.end(), {{"step error RMS", rms(p.step_error)},
                             {"arithmetic RMS", rms(p.arithmetic)},
                             {"look-ups per ray", decimals(p.samples_per_ray, 1)},
                             {"segments per ray", decimals(p.steps_per_ray, 1)},
                             {"GPU ms", spread_text(gpu_ms(p))},
                             {"wall ms", spread_text(wall_ms(p))},
                             {"CPU ms", spread_text(cpu_ms(p))},
                             {"atlas MiB", decimals(double(p.atlas_bytes) / (1 << 20), 2)}});
  return facts;
}

Facts facts_of(const ForeignPoint& p) {
  const Deviation& radiance = p.error.radiance;
  const double time = p.picture.time_ms;
  return {{"RMS", two_digits(p.rms())},
          {"over", p.opaque ? "R G B" : "R G B A"},
          {"radiance max, pixel", max_text(radiance)},
          {"radiance 99 %", two_digits(radiance.p99)},
          {"radiance mean", two_digits(radiance.mean)},
          {"alpha RMS", p.opaque ? "–" : two_digits(p.error.alpha.rms)},
          {"ms, as given", time > 0 ? decimals(time, 1) : "–"}};
}

void add_row(TextTable& rows, const std::string& name, const Facts& facts) {
  for (const auto& [label, text] : facts) set_cell(rows, name, label, text);
}

TextTable points_table(const StudyResults& results) {
  TextTable rows = {{"variant"}};
  for (const StudyPoint& p : results.points) {
    const std::string chosen = p.chosen ? ": " + variant_name(*p.chosen) : "";
    add_row(rows, variant_name(p.variant) + chosen, facts_of(p));
  }
  return rows;
}

/// The facts that fit beside a point of a plot.
Html plot_facts(const StudyResults& results) {
  constexpr const char* brief[] = {
      "RMS", "radiance max, pixel", "look-ups per ray", "CPU ms", "wall ms", "GPU ms"};
  std::map<std::string, Facts> all;
  for (const StudyPoint& p : results.points) {
    Facts& shown = all[variant_name(p.variant)];
    if (p.chosen) shown.emplace_back("chosen", variant_name(*p.chosen));
    for (const auto& fact : facts_of(p))
      if (std::ranges::count(brief, fact.first)) shown.push_back(fact);
  }
  for (const ForeignPoint& p : results.foreign) all[shown_name(p)] = facts_of(p);
  return html_facts(all);
}

/// For each error, the cheapest measured variant that stays below it.
TextTable cheapest_table(const StudyResults& results) {
  TextTable rows = {{"RMS at most", "fewest look-ups per ray", "least processor time"}};
  const auto cheapest = [&](double rms, const auto& cost, const char* unit) -> std::string {
    const StudyPoint* best = nullptr;
    for (const StudyPoint& p : results.points)
      if (p.rms() <= rms && cost(p) > 0 && (!best || cost(p) < cost(*best))) best = &p;
    if (!best) return "–";
    return variant_name(best->variant) + ": " + decimals(cost(*best), 1) + unit;
  };
  const auto look_ups = [](const StudyPoint& p) { return p.samples_per_ray; };
  for (const double rms : usual_rms)
    rows.push_back(
        {power_text(rms), cheapest(rms, look_ups, ""), cheapest(rms, median_cpu_ms, " ms")});
  return rows;
}

Html pair_of(const fs::path& folder, const std::string& name, const std::string& file_name,
             double scale) {
  const std::string file = file_name + ".png";
  // Beside a point of a plot the name stands above the pictures.
  const Html label = Html("<span class=\"name\">") + name + ": </span>";
  return Html("<div class=\"pair\">") +
         html_figure(folder / pictures_folder / file, label + "picture", thumbnail_width, name) +
         html_figure(folder / differences_folder / file,
                     label + "difference, ±" + two_digits(scale), thumbnail_width, name) +
         "</div>\n";
}

Html gallery(const StudyResults& results, const fs::path& folder) {
  Html out =
      "<p>Every variant has its picture and the difference from the reference: blue where the "
      "picture is darker, red where it is brighter. The caption has the difference at full "
      "colour.</p>\n<div class=\"gallery\">\n";
  for (const ForeignPoint& p : results.foreign)
    out += pair_of(folder, shown_name(p), file_name(p.picture), p.difference_scale);
  for (const StudyPoint& p : results.points)
    out += pair_of(folder, variant_name(p.variant), file_name(p.variant), p.difference_scale);
  return out + "</div>\n";
}

/// One reference for each resolution.
Html references(const StudyResults& results, const fs::path& folder) {
  std::set<std::string> names;
  Html out;
  for (const StudyPoint& p : results.points) {
    const std::string name = reference_name(p.variant);
    if (!names.insert(name).second) continue;
    out += html_figure(folder / (name + ".png"), "the picture, by the reference", picture_width);
  }
  if (fs::exists(folder / turning_name))
    out += Html("<p><a href=\"") + std::string(turning_name) + "\">Turn the picture</a></p>\n";
  return out;
}

TextTable foreign_table(const StudyResults& results) {
  TextTable rows = {{"renderer"}};
  for (const ForeignPoint& p : results.foreign) add_row(rows, shown_name(p), facts_of(p));
  return rows;
}

Html plots(const StudyResults& results, const fs::path& folder) {
  Html html;
  for (const Plot& plot : plots_of(results)) html += write_plot(plot, folder);
  return html + plot_facts(results);
}

}  // namespace

std::string reference_name(const Variant& variant) {
  if (variant.resolution.x == 0) return "reference";
  return "reference_" + parameter_text(scene_of(variant, {}), "resolution");
}

TextTable rules_table(const StudyResults& results) {
  TextTable rows = {{"rule"}};
  std::map<std::string, double> baseline;  // porter-duff's processor time, by the column
  for (const StudyPoint& p : results.points)
    if (rule_name(p.variant) == "porter-duff")
      baseline.emplace(sampling_name(p.variant), median_cpu_ms(p));
  for (const StudyPoint& p : results.points) {
    const std::string column = sampling_name(p.variant);
    const double own = median_cpu_ms(p), whole = baseline[column];
    const std::string share = own > 0 && whole > 0 ? " (" + decimals(own / whole, 2) + ")" : "";
    set_cell(rows, rule_name(p.variant), column, two_digits(p.rms()) + share);
  }
  return rows;
}

TextTable skipped_table(const std::vector<SkippedVariant>& skipped) {
  TextTable rows = {{"skipped", "why"}};
  for (const SkippedVariant& s : skipped) {
    const std::string rule = rule_name(s.variant) + ": ", sampling = sampling_name(s.variant);
    const std::string& reason = s.reason;
    const auto row = std::ranges::find_if(
        rows, [&](const auto& cells) { return cells[0].starts_with(rule) && cells[1] == reason; });
    if (row == rows.end())
      rows.push_back({rule + sampling, reason});
    else
      row->front() += ", " + sampling;
  }
  return rows;
}

void write_report(const StudyResults& results, const fs::path& folder) {
  write_sections(
      folder, "results", "psivox study of " + fs::path(results.input).filename().string(),
      {{.html = first_screen(results, references(results, folder)),
        .markdown = conclusion_text(results) + " " + eight_bits_note + "\n\n```sh\n" +
                    command_of(results) + "\n```\n\n"},
       {"Cheapest ways to an error",
        "Error is the RMS over R G B A of the GPU's picture less the reference, in linear "
        "radiance. For each error the table names the measured variant that stays below it with "
        "the fewest field look-ups per ray, and the one with the least processor time.",
        cheapest_table(results), Cells::words},
       {.title = "Plots", .text = clock_note(results), .html = plots(results, folder)},
       {"Other renderers",
        "Pictures of other renderers, through the same camera, less the reference. A picture "
        "whose "
        "alpha is 1 everywhere is compared in R G B, over the scene's background or black; the "
        "others in R G B A, premultiplied. Times are as given: psivox did not measure them.",
        foreign_table(results)},
       {"Rules by samplings",
        "Each cell has the RMS over R G B A against the reference and, in parentheses, the "
        "processor time of the march over that of porter-duff in the same column.",
        rules_table(results)},
       {.title = "Rules", .html = rule_list(results)},
       {"What an error takes",
        "Each cell has the field look-ups per ray and the processor time of the march at an RMS, "
        "interpolated between measured points linearly in the logarithms. ≤: the coarsest point "
        "already reaches the RMS; –: no point reaches it.",
        needs_table(results)},
       {.title = "All numbers",
        .html =
            Html("<p>Times are medians, with the quartiles in parentheses. The step error is the "
                 "march in double less the reference; the arithmetic error is the GPU's picture "
                 "less the march in double.</p>\n") +
            html_table(points_table(results))},
       {"Skipped", "", skipped_table(results.skipped), Cells::words},
       {.title = "Pictures", .html = gallery(results, folder)},
       {.title = "Data",
        .html = Html("<p>All numbers: <a href=\"results.csv\">results.csv</a>, <a "
                     "href=\"results.json\">results.json</a>. Cite as: ") +
                citation(results) + ".</p>\n"},
       {.title = "Scene", .html = Html("<pre>") + results.scene + "</pre>\n"}});
}

}  // namespace psivox
