#include "scene/color.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/mat3x3.hpp>
#include <vector>

namespace psivox {
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
    const glm::dvec3 white = (*this)(6500);
    for (glm::dvec3& row : rows_) row -= std::log(white.y);
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
