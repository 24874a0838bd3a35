#include "scene/color.h"

#include <algorithm>
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

}  // namespace psivox
