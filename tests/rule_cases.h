#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "march/shader_math.h"

// Shared by the tests of formulas: test values, definitions in long double, errors.

namespace psivox {

using wide = long double;

/// Smallest number whose relative error is checked. Below e^{-87} = 1.6e-38 float32 is subnormal
/// and decay() stops; transparencies of that size do not matter.
inline constexpr wide least_float = 1e-36L;

/// {0} and log-spaced values with odd digits, so that no structure of binary is favoured.
inline std::vector<double> log_spaced(double first, double last, int per_decade) {
  std::vector<double> values{0};
  const double decades = std::log10(last / first);
  const int n = int(std::lround(decades * per_decade));
  for (int i = 0; i <= n; ++i)
    values.push_back(first * std::pow(10.0, decades * i / n) * (1 + 0.003 * std::sin(7.0 * i)));
  return values;
}

inline wide relative(wide value, wide exact) {
  if (std::abs(exact) < least_float && std::abs(value) < least_float) return 0;
  return std::abs(value - exact) / std::abs(exact);
}

/// Largest error seen, and its place.
struct Worst {
  wide error = 0;
  double at = 0, at_back = 0;
  void see(wide e, double x, double x_back = 0) {
    if (!(e <= error)) error = e, at = x, at_back = x_back;
  }
};

inline void report(const char* name, const Worst& worst) {
  char text[64];
  std::snprintf(text, sizeof text, "%.3Lg", worst.error);
  testing::Test::RecordProperty(name, text);
  std::snprintf(text, sizeof text, "%.3Lg at %.4g, %.4g", worst.error, worst.at, worst.at_back);
  std::printf("  %-28s %s\n", name, text);
}

/// Largest relative errors of a rule's weights at the ends.
struct WorstWeights {
  Worst front, back;
  template <typename Weights>
  void see(const Weights& w, wide exact_front, wide exact_back, double x_f, double x_b) {
    front.see(relative(w.front, exact_front), x_f, x_b);
    back.see(relative(w.back, exact_back), x_f, x_b);
  }
  void expect(const std::string& rule, wide bound) const {
    report((rule + " w_f").c_str(), front);
    report((rule + " w_b").c_str(), back);
    EXPECT_LE(front.error, bound) << rule;
    EXPECT_LE(back.error, bound) << rule;
  }
};

// The definitions. expm1l and log1pl are accurate to an ulp of long double, 1e-19.
inline wide exact_decay(wide x) { return std::exp(-x); }
inline wide exact_opacity(wide x) { return -std::expm1(-x); }
inline wide exact_one_minus_h(wide t) {
  if (t > 0.1L) return 1 - exact_opacity(t) / t;
  wide sum = 0, term = 1;  // t/2 - t^2/6 + ...: 14 terms leave out 0.1^15/16! = 5e-29
  for (int n = 1; n <= 14; ++n) {
    term *= -t / (n + 1);
    sum -= term;
  }
  return sum;
}
inline wide exact_h(wide t) { return t > 0 ? exact_opacity(t) / t : 1; }

struct WideWeights {
  wide front = 0, middle = 0, back = 0, zeta = 1;
};

template <typename Math>
auto segment_of(typename Math::real x_f, typename Math::real x_b) {
  using real = typename Math::real;
  const real depth = real(0.5) * x_f + real(0.5) * x_b;
  return typename Math::Segment{x_f, real(0.5) * (x_f + x_b), x_b, 1, depth};
}

/// GoogleTest's names for the two precisions glsl32::Math and glsl::Math.
using Precisions = testing::Types<glsl32::Math, glsl::Math>;
class PrecisionNames {
 public:
  template <typename T>
  static std::string GetName(int i) {
    return i == 0 ? "Float" : "Double";
  }
};

}  // namespace psivox
