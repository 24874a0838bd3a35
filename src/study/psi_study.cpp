// Errors of the rules themselves, on one segment whose attenuation is linear between its ends.

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "base/statistics.h"
#include "base/text_file.h"
#include "march/formula_march.h"
#include "psivox/image.h"
#include "psivox/study.h"
#include "scene/color.h"
#include "study/page.h"
#include "study/results.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// A rule's result for a segment whose luminance is linear too. A rule that reads the middle gets
/// the mean of the ends there.
struct Outcome {
  double psi = 1, zeta = 1;    ///< C = L_f (1 - psi) + L_b (psi - zeta)
  double front = 0, back = 0;  ///< 1 - psi and psi - zeta, with their own precision

  explicit Outcome(const RuleWeights& w)
      : psi(1 - w.front - w.middle / 2),
        zeta(std::exp(-w.depth)),
        front(w.front + w.middle / 2),
        back(w.back + w.middle / 2) {}
};

struct SegmentError {
  double psi = 0, zeta = 0;
  double color = 0;  ///< the radiance error with the largest magnitude, over luminances from 0 to 1
};

SegmentError difference(const Outcome& a, const Outcome& b) {
  SegmentError e{a.psi - b.psi, a.zeta - b.zeta, 0};
  const double front = a.front - b.front, back = a.back - b.back;
  for (const double color : {front, back, front + back})
    e.color = std::max(e.color, std::abs(color));
  // If zeta is right, the errors of the ends are opposite. Rounding must not choose between them.
  const bool at_front = std::abs(front) >= 0.999 * e.color;
  e.color = std::copysign(e.color, at_front                            ? front
                                   : std::abs(back) >= 0.999 * e.color ? back
                                                                       : front + back);
  return e;
}

SegmentError rule_error(Integrator rule, double x_f, double x_b) {
  return difference(Outcome(rule_weights_double(rule, x_f, x_b)),
                    Outcome(rule_weights_double(Integrator::psi_exact, x_f, x_b)));
}

/// Rounds the ends to float first, so that their own rounding does not count.
SegmentError float_error(Integrator rule, double x_f, double x_b) {
  x_f = double(float(x_f));
  x_b = double(float(x_b));
  return difference(Outcome(rule_weights_float(rule, x_f, x_b)),
                    Outcome(rule_weights_double(rule, x_f, x_b)));
}

/// A square of segments, indexed by their ends: `length` maps u from 0 to 1 to an optical length.
struct Domain {
  const char* name;
  const char* caption;
  double (*length)(double u);
};

constexpr Domain domains[] = {
    {"opacities", "end opacities 0 to 1",
     [](double u) { return -std::log1p(-std::min(u, 1 - 1e-12)); }},
    {"lengths", "optical lengths 1e-4 to 1e4, logarithmic",
     [](double u) { return std::pow(10, 8 * u - 4); }},
};

struct Measure {
  const char* name;
  const char* title;
  SegmentError (*error)(Integrator, double, double);
};
constexpr Measure measures[] = {{"rule", "The rules against psi-exact, in double", rule_error},
                                {"float32", "Float32 against double, rule by rule", float_error}};

struct Quantity {
  const char* name;
  double SegmentError::*member;
};
constexpr Quantity quantities[] = {
    {"psi", &SegmentError::psi}, {"zeta", &SegmentError::zeta}, {"color", &SegmentError::color}};

constexpr int cells = 200;  // per side of a domain; a cell is a pixel

/// The errors over a domain. The front end grows to the right, the back end upwards.
struct Surface {
  std::vector<SegmentError> errors;

  Surface(Integrator rule, const Domain& domain, const Measure& measure) {
    for (int y = 0; y < cells; ++y)
      for (int x = 0; x < cells; ++x)
        errors.push_back(measure.error(rule, domain.length((x + 0.5) / cells),
                                       domain.length((cells - y - 0.5) / cells)));
  }

  ErrorSum sum(double SegmentError::*member) const {
    ErrorSum sum;
    for (const SegmentError& e : errors) sum.add(e.*member, sum.count);
    return sum;
  }

  /// Blue below 0, red above, full colour at `scale`.
  Image picture(double SegmentError::*member, double scale) const {
    Image image = rgba_image(cells, cells, 1);
    float* pixel = image.rgba().data();
    for (const SegmentError& e : errors) {
      const double u = scale > 0 ? 0.5 + 0.5 * e.*member / scale : 0.5;
      const glm::dvec3 color = colormap_color(Colormap::coolwarm, u);
      for (int c = 0; c < 3; ++c) pixel[c] = float(color[c]);
      pixel += 4;
    }
    return image;
  }
};

std::vector<Integrator> segment_rules() {
  std::vector<Integrator> rules;
  for (const IntegratorInfo& row : integrators)
    if (is_segment_rule(row.id)) rules.push_back(row.id);
  return rules;
}

/// The tables and pictures of one domain and measure. Calls `did` after each rule.
Section section_of(const Domain& domain, const Measure& measure, const fs::path& folder,
                   const std::function<void()>& did, std::vector<Json>& csv) {
  Section section{.title = std::string(measure.title) + ": " + domain.caption,
                  .table = {{"rule", "ΔΨ, RMS (max)", "Δζ, RMS (max)", "Δ colour, RMS (max)"}}};
  Html figures("<div class=\"gallery\">\n");
  for (const Integrator rule : segment_rules()) {
    const Surface surface(rule, domain, measure);
    const std::string name = rule_name({{.integrator = rule}});
    const std::string file = std::string(domain.name) + "_" + measure.name + "_" + name + "_";
    section.table.push_back({name});
    Json row = {{"integrator", name}, {"ends", domain.name}, {"error", measure.name}};
    for (const Quantity& quantity : quantities) {
      const ErrorSum sum = surface.sum(quantity.member);
      row[std::string(quantity.name) + "_rms"] = sum.rms();
      row[std::string(quantity.name) + "_max"] = sum.max;
      section.table.back().push_back(two_digits(sum.rms()) + " (" + two_digits(sum.max) + ")");
      const fs::path png = folder / "pictures" / (file + quantity.name + ".png");
      write_image(surface.picture(quantity.member, sum.max), png);
      figures += html_figure(png, name + ", " + quantity.name + ": ±" + two_digits(sum.max), cells);
    }
    csv.push_back(std::move(row));
    did();
  }
  section.html = figures + "</div>\n";
  return section;
}

}  // namespace

void run_psi_study(const fs::path& folder, const Progress& progress) {
  const WrittenFolder written = study_folder(folder, false);
  make_folder(folder / "pictures");
  std::vector<Section> sections = {
      {.text =
           "The medium is one segment of length 1 whose attenuation is linear between its ends. "
           "Its colour is C = L_f (1 - Ψ) + L_b (Ψ - ζ); the error of the colour is the largest "
           "for luminances from 0 to 1. In the pictures the attenuation of the front end grows "
           "to the right and that of the back end upwards. Blue is below 0 and red above; the "
           "caption has the error at full colour."}};
  double done = 0;
  const auto did = [&] {
    done += 1;
    if (progress) progress(done / (4 * double(segment_rules().size())));
  };
  std::vector<Json> csv;
  for (const Measure& measure : measures)
    for (const Domain& domain : domains)
      sections.push_back(section_of(domain, measure, folder, did, csv));
  write_text((folder / "psi.csv").string(), csv_text(csv));
  write_sections(folder, "psi", "psivox study --psi", sections);
}

}  // namespace psivox
