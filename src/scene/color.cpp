#include "scene/color.h"

#include <array>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <numbers>

namespace psivox {
namespace {

constexpr double pi = std::numbers::pi;

/// D65 as in VTK.
const glm::dvec3 white{0.9505, 1.000, 1.089};

glm::dvec3 lab_from_srgb(const glm::dvec3& code) {
  const glm::dmat3 xyz_from_rgb(0.4124, 0.2126, 0.0193, 0.3576, 0.7152, 0.1192, 0.1805, 0.0722,
                                0.9505);
  glm::dvec3 f = xyz_from_rgb * linear_from_srgb(code) / white;
  for (int c = 0; c < 3; ++c) f[c] = f[c] > 0.008856 ? std::cbrt(f[c]) : 7.787 * f[c] + 16.0 / 116;
  return {116 * f.y - 16, 500 * (f.x - f.y), 200 * (f.y - f.z)};
}

/// Colours beyond sRGB are scaled until the greatest code is 1, then cut at 0, as in VTK.
glm::dvec3 srgb_from_lab(const glm::dvec3& lab) {
  const double y = (lab.x + 16) / 116;
  glm::dvec3 f{y + lab.y / 500, y, y - lab.z / 200};
  for (int c = 0; c < 3; ++c) {
    const double cube = f[c] * f[c] * f[c];
    f[c] = cube > 0.008856 ? cube : (f[c] - 16.0 / 116) / 7.787;
  }
  const glm::dmat3 rgb_from_xyz(3.2406, -0.9689, 0.0557, -1.5372, 1.8758, -0.2040, -0.4986, 0.0415,
                                1.0570);
  const glm::dvec3 code = srgb_from_linear(rgb_from_xyz * (f * white));
  return glm::max(code / std::max({code.r, code.g, code.b, 1.0}), glm::dvec3(0));
}

/// Lab in polar form: magnitude, saturation (angle from the L axis) and hue.
struct Msh {
  double M, s, h;
};

Msh msh_from_lab(const glm::dvec3& lab) {
  const double M = glm::length(lab);
  const double s = M > 0.001 ? std::acos(std::min(lab.x / M, 1.0)) : 0;
  return {M, s, s > 0.001 ? std::atan2(lab.z, lab.y) : 0};
}

glm::dvec3 lab_from_msh(const Msh& m) {
  return m.M *
         glm::dvec3(std::cos(m.s), std::sin(m.s) * std::cos(m.h), std::sin(m.s) * std::sin(m.h));
}

/// The hue for an unsaturated colour of magnitude M next to a saturated one.
double adjusted_hue(const Msh& saturated, double M) {
  if (saturated.M >= M - 0.1) return saturated.h;
  const double spin = saturated.s * std::sqrt(M * M - saturated.M * saturated.M) /
                      (saturated.M * std::sin(saturated.s));
  return saturated.h + (saturated.h > -0.3 * pi ? spin : -spin);
}

glm::dvec3 hsv_from_rgb(const glm::dvec3& c) {
  const double most = std::max({c.r, c.g, c.b}), spread = most - std::min({c.r, c.g, c.b});
  if (spread <= 0) return {0, 0, most};
  double sixths;
  if (c.r == most)
    sixths = (c.g - c.b) / spread;
  else if (c.g == most)
    sixths = 2 + (c.b - c.r) / spread;
  else
    sixths = 4 + (c.r - c.g) / spread;
  return {(sixths < 0 ? sixths + 6 : sixths) / 6, spread / most, most};
}

glm::dvec3 rgb_from_hsv(const glm::dvec3& hsv) {
  const auto channel = [&](double shift) {
    const double k = std::fmod(shift + 6 * hsv.x, 6);
    return hsv.z * (1 - hsv.y * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
  };
  return {channel(5), channel(3), channel(1)};
}

}  // namespace

glm::dvec3 linear_from_srgb(const glm::dvec3& code) {
  glm::dvec3 light;
  for (int c = 0; c < 3; ++c) light[c] = linear_from_srgb(code[c]);
  return light;
}

glm::dvec3 srgb_from_linear(const glm::dvec3& light) {
  glm::dvec3 code;
  for (int c = 0; c < 3; ++c) code[c] = srgb_from_linear(light[c]);
  return code;
}

glm::dvec3 mix_lab(const glm::dvec3& a, const glm::dvec3& b, double t) {
  return srgb_from_lab(glm::mix(lab_from_srgb(a), lab_from_srgb(b), t));
}

glm::dvec3 mix_diverging(const glm::dvec3& a, const glm::dvec3& b, double t) {
  Msh from = msh_from_lab(lab_from_srgb(a)), to = msh_from_lab(lab_from_srgb(b));
  const double turn = std::abs(from.h - to.h), angle = std::min(turn, 2 * pi - turn);
  if (from.s > 0.05 && to.s > 0.05 && angle > 0.33 * pi) {
    const Msh middle{std::max({from.M, to.M, 88.0}), 0, 0};
    (t < 0.5 ? to : from) = middle;
    t = t < 0.5 ? 2 * t : 2 * t - 1;
  }
  if (from.s < 0.05 && to.s > 0.05)
    from.h = adjusted_hue(to, from.M);
  else if (to.s < 0.05 && from.s > 0.05)
    to.h = adjusted_hue(from, to.M);
  return srgb_from_lab(lab_from_msh(
      {std::lerp(from.M, to.M, t), std::lerp(from.s, to.s, t), std::lerp(from.h, to.h, t)}));
}

glm::dvec3 mix_hsv(const glm::dvec3& a, const glm::dvec3& b, double t, bool shortest) {
  glm::dvec3 from = hsv_from_rgb(a), to = hsv_from_rgb(b);
  if (shortest && std::abs(from.x - to.x) > 0.5) (from.x > to.x ? from : to).x -= 1;
  glm::dvec3 hsv = glm::mix(from, to, t);
  if (hsv.x < 0) hsv.x += 1;
  return rgb_from_hsv(hsv);
}

namespace {

/// Second radiation constant hc/k [nm K].
constexpr double c2 = 1.438776877e7;
constexpr double coldest = 200;       ///< [K]
constexpr double reference_nm = 560;  ///< the middle of the visible, see XyzTable

/// A Gaussian with its own inverse width [1/nm] on either side of its mean [nm].
double lobe(double nm, double mean, double inverse_below, double inverse_above) {
  const double t = (nm - mean) * (nm < mean ? inverse_below : inverse_above);
  return std::exp(-0.5 * t * t);
}

/// The CIE 1931 2 degree colour-matching functions: the multi-lobe fit of C. Wyman, P.-P. Sloan and
/// P. Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2),
/// 2013. Its lobes end too soon in the red, X's before Y's, which would make cold bodies green.
/// From 680 nm on, an exponential of constant chromaticity (x 0.7347, y 0.2653) replaces the fit.
glm::dvec3 color_matching(double nm) {
  if (nm > 680) return glm::dvec3(0.01136, 0.004102, 0) * std::exp(-0.0703 * (nm - 700));
  return {0.362 * lobe(nm, 442.0, 0.0624, 0.0374) + 1.056 * lobe(nm, 599.8, 0.0264, 0.0323) -
              0.065 * lobe(nm, 501.1, 0.0490, 0.0382),
          0.821 * lobe(nm, 568.8, 0.0213, 0.0247) + 0.286 * lobe(nm, 530.9, 0.0613, 0.0322),
          1.217 * lobe(nm, 437.0, 0.0845, 0.0278) + 0.681 * lobe(nm, 459.0, 0.0385, 0.0725)};
}

/// ITU-R BT.709 primaries and white D65, columns.
constexpr double rgb_from_xyz[9] = {3.2409699419,  -0.9692436363, 0.0556300797,
                                    -1.5373831776, 1.8759675015,  -0.2039769589,
                                    -0.4986107603, 0.0415550574,  1.0569715142};

/// ln of XYZ times (e^{c2/(560 nm T)} - 1), over u = 1/T. The factor removes Planck's law at one
/// wavelength; the rest is smooth down to u = 0 (finite there, by Rayleigh and Jeans) and nearly
/// linear in u. Linear interpolation is off by h^2/8 times the variance of c2/wavelength, 1.3e7 K^2
/// for X, which has two bands; h = 1/(200 K)/2048 makes it 1e-5.
class XyzTable {
 public:
  XyzTable() {
    const std::vector<Band> bands = make_bands();
    for (std::size_t i = 0; i < rows_.size(); ++i)
      rows_[i] = glm::log(integral(bands, double(i) * step));
    const double luminance = (*this)(6500).y;
    for (glm::dvec3& row : rows_) row -= std::log(luminance);
  }

  glm::dvec3 operator()(double kelvin) const {
    const double u = 1 / kelvin, place = u / step;
    const auto row = std::min(std::size_t(place), rows_.size() - 2);
    const double t = place - double(row);
    const glm::dvec3 smooth = glm::mix(rows_[row], rows_[row + 1], t);
    return glm::exp(smooth) / std::expm1(c2 / reference_nm * u);
  }

 private:
  static constexpr int intervals = 2048;
  static constexpr double step = 1 / coldest / intervals;  ///< [1/K]

  /// A step of the midpoint rule, 2 nm wide.
  struct Band {
    double nm;
    glm::dvec3 weight;  ///< color_matching, with the fifth power of Planck's law
  };

  /// Aligned with the change of formula at 680 nm.
  static std::vector<Band> make_bands() {
    std::vector<Band> bands;
    for (int nm = 361; nm < 830; nm += 2)
      bands.push_back({double(nm), color_matching(nm) * std::pow(reference_nm / nm, 5)});
    return bands;
  }

  static glm::dvec3 integral(const std::vector<Band>& bands, double u) {
    const double reference = std::expm1(c2 / reference_nm * u);
    glm::dvec3 sum{0};
    for (const Band& band : bands) {
      const double ratio =
          u == 0 ? band.nm / reference_nm : reference / std::expm1(c2 / band.nm * u);
      sum += band.weight * ratio;
    }
    return sum;
  }

  std::array<glm::dvec3, intervals + 1> rows_;
};

}  // namespace

glm::dvec3 black_body(double kelvin) {
  if (!(kelvin > coldest)) return glm::dvec3(0);
  static const XyzTable xyz;
  const double(&m)[9] = rgb_from_xyz;
  const glm::dmat3 rgb(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
  return glm::max(rgb * xyz(kelvin), glm::dvec3(0));
}

}  // namespace psivox
