// Computes the constants of shaders/math/mills.glsl, shaders/math/dawson.glsl and
// shaders/integrators/psi_fit.glsl, and prints them as they appear there, with the largest error of
// each. Deterministic; long double throughout; takes a minute or two.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

namespace {

using real = long double;
using Vector = std::vector<real>;
constexpr real pi = std::numbers::pi_v<real>;

// --- the functions -------------------------------------------------------------------------------

/// e = sqrt(pi) erfcx(p) = 2 int_0^inf e^{-t^2-2pt} dt and c = 1 - p e = 2 int t e^{-t^2-2pt} dt,
/// by the trapezoidal rule after t = s e^{u - e^{-u}} (exp-sinh), which converges exponentially.
struct Mills {
  real e = 0, c = 0;
  explicit Mills(real p) {
    const real h = 1 / 32.0L, s = 1 / (1 + p);
    for (int i = -160; i <= 120; ++i) {
      const real u = i * h, shrink = std::exp(-u), t = s * std::exp(u - shrink);
      const real w = 2 * h * t * (1 + shrink) * std::exp(-t * (t + 2 * p));
      e += w;
      c += w * t;
    }
  }
};

/// Dawson's integral F = e^{-x^2} int_0^x e^{t^2} dt and n = 2 x F - 1, by a series of positive
/// terms. From x = 12 on, n uses its asymptotic series, whose smallest term is e^{-144}.
struct Dawson {
  real f = 0, n = 0;
  explicit Dawson(real x) {
    if (x > 12) {
      const real v = 1 / (2 * x * x);
      for (real term = v, k = 1; term > 1e-22L * n; ++k) n += term, term *= (2 * k + 1) * v;
      f = (1 + n) / (2 * x);
      return;
    }
    real term = x;
    for (int k = 0; k < 2000; ++k) f += term / (2 * k + 1), term *= x * x / (k + 1);
    f *= std::exp(-x * x);
    n = 2 * x * f - 1;
  }
};

/// (Psi - zeta)/(1 - zeta): the back end's share of the light from a segment of linear attenuation.
real share_of_back(real f, real b) {
  const real zeta = std::exp(-(f + b) / 2), opacity = -std::expm1(-(f + b) / 2);
  if (std::max(f, b) <= 4) {  // as in shaders/math/linear_psi.glsl; 4^70/70! = 1e-58
    real above = zeta / 70, j = zeta / 69;
    for (int k = 68; k >= 1; --k) {
      const real next = (zeta + f * j + (b - f) * above) / (k + 1);
      above = j, j = next;
    }
    return (f * (j - above) + b * above) / opacity;
  }
  real psi = 0;
  if (f == b) {
    psi = opacity / f;
  } else if (b > f) {
    const real w = std::sqrt(2 * (b - f));
    psi = (Mills(f / w).e - zeta * Mills(b / w).e) / w;
  } else {
    const real w = std::sqrt(2 * (f - b));
    psi = 2 * (Dawson(f / w).f - zeta * Dawson(b / w).f) / w;
  }
  return (psi - zeta) / opacity;
}

// --- polynomials ---------------------------------------------------------------------------------

/// Coefficients of y^0, y^1, ... of f's Chebyshev expansion over [-1, 1], cut off at `degree`.
Vector chebyshev(const std::function<real(real)>& f, int degree) {
  constexpr int n = 128;
  Vector values(n), result(std::size_t(degree) + 1), before{1}, now{0, 1};
  for (int k = 0; k < n; ++k) values[std::size_t(k)] = f(std::cos(pi * (k + 0.5L) / n));
  for (int j = 0; j <= degree; ++j) {
    real c = 0;
    for (int k = 0; k < n; ++k)
      c += values[std::size_t(k)] * std::cos(pi * j * (k + 0.5L) / n) * (j ? 2 : 1) / n;
    const Vector& t = j ? now : before;
    for (std::size_t i = 0; i < t.size(); ++i) result[i] += c * t[i];
    if (j == 0) continue;
    Vector next(now.size() + 1);  // T_{j+1} = 2 y T_j - T_{j-1}
    for (std::size_t i = 0; i < now.size(); ++i) next[i + 1] += 2 * now[i];
    for (std::size_t i = 0; i < before.size(); ++i) next[i] -= before[i];
    before = now, now = next;
  }
  return result;
}

void print_polynomial(const char* name, const std::function<real(real)>& f, int degree,
                      int digits) {
  const Vector c = chebyshev(f, degree);
  real worst = 0;
  for (int i = 0; i <= 1000; ++i) {
    const real y = -std::cos(pi * i / 1000);
    real sum = 0;
    for (std::size_t k = c.size(); k-- > 0;) sum = sum * y + c[k];
    worst = std::max(worst, std::abs(sum / f(y) - 1));
  }
  std::printf("// %s, degree %d, relative error %.1Le\n  real s = real(%.*Le);\n", name, degree,
              worst, digits - 1, c.back());
  const std::size_t per_line = digits > 10 ? 2 : 4;
  for (std::size_t k = c.size() - 1; k > 0;) {
    const std::size_t count = std::min(per_line, k);
    std::printf("  s = %sy * s", std::string(count - 1, '(').c_str());
    for (std::size_t i = 0; i < count; ++i)
      std::printf("%s + real(%.*Le)%s", i ? " * y" : "", digits - 1, c[--k],
                  i + 1 < count ? ")" : ";\n");
  }
}

void print_special_functions() {
  // rho, with r = 1/e - p = c/e: two of its values at either end of p are 1/2
  const auto rho = [](real y) {
    if (y > 1 - 1e-15L) return 0.5L;
    const real p = 3 * (1 + y) / (1 - y);
    const Mills m(p);
    return m.c / m.e * (p + std::sqrt(pi) / 2);
  };
  const auto small = [](real y) {
    const real x = std::sqrt(2 * (1 + y));
    return x < 1e-9L ? 1 : Dawson(x).f / x;
  };
  const auto middle = [](real y) {
    const real x = 3 + y;
    return 2 * x * x * Dawson(x).n;
  };
  const auto large = [](real y) {
    const real v = (1 + y) / 32;
    return v < 1e-15L ? 1 : 2 / v * Dawson(1 / std::sqrt(v)).n;
  };
  for (const bool single : {true, false}) {
    const int digits = single ? 9 : 17;
    std::printf("\n== %d bits ==\n", single ? 32 : 64);
    print_polynomial("mills.glsl, y = (p - 3)/(p + 3)", rho, single ? 12 : 22, digits);
    print_polynomial("dawson.glsl, F/x below 2, y = x^2/2 - 1", small, single ? 10 : 17, digits);
    print_polynomial("dawson.glsl, 2 x^2 N of 2 to 4, y = x - 3", middle, single ? 12 : 20, digits);
    print_polynomial("dawson.glsl, 2 x^2 N from 4 on, y = 32/x^2 - 1", large, single ? 7 : 22,
                     digits);
  }
}

// --- psi_fit -------------------------------------------------------------------------------------

/// A monomial f^i b^j s^k.
struct Term {
  int i, j, k;
};
const std::vector<Term> above{{2, 0, 0}, {1, 1, 0}, {0, 2, 0}, {1, 0, 1}, {0, 1, 1}};
const std::vector<Term> below{{2, 0, 0}, {0, 2, 0}, {0, 1, 1}, {2, 0, 1}, {1, 1, 1},
                              {0, 2, 1}, {3, 0, 0}, {2, 1, 0}, {1, 2, 0}};

struct Point {
  real f, b, share, opacity;
};

std::vector<Point> grid(real first, int per_decade) {
  Vector xs{0};
  const int n = int(std::lround(std::log10(1e4L / first) * per_decade));
  for (int i = 0; i <= n; ++i) xs.push_back(first * std::pow(1e4L / first, real(i) / n));
  std::vector<Point> points;
  for (const real f : xs)
    for (const real b : xs)
      if (f + b > 0) points.push_back({f, b, share_of_back(f, b), -std::expm1(-(f + b) / 2)});
  return points;
}

/// The s of psi_fit.glsl.
real root(const Vector& k, real f, real b) {
  return std::sqrt(1 + std::abs(k[0]) * b + std::abs(k[1]) * f + std::abs(k[2]) * f * f) - 1;
}

/// Solves with A by Cholesky; empty if A is not positive definite.
Vector solve(std::vector<Vector> a, Vector y) {
  const std::size_t n = y.size();
  Vector scale(n);
  for (std::size_t i = 0; i < n; ++i) scale[i] = 1 / std::sqrt(a[i][i]);
  for (std::size_t i = 0; i < n; ++i) {
    y[i] *= scale[i];
    for (std::size_t j = 0; j < n; ++j) a[i][j] *= scale[i] * scale[j];
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      real sum = a[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
      if (i == j && !(sum > 0)) return {};
      a[i][j] = i == j ? std::sqrt(sum) : sum / a[j][j];
    }
    for (std::size_t k = 0; k < i; ++k) y[i] -= a[i][k] * y[k];
    y[i] /= a[i][i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) y[i] -= a[k][i] * y[k];
    y[i] /= a[i][i];
  }
  for (std::size_t i = 0; i < n; ++i) y[i] *= scale[i];
  return y;
}

/// The terms of numerator and denominator at a point; the denominator's are multiplied by -share.
void fill_row(const Point& p, real s, Vector& row) {
  std::size_t n = 0;
  const auto power = [](real x, int k) {
    return k == 0 ? 1 : k == 1 ? x : k == 2 ? x * x : x * x * x;
  };
  for (const Term& t : above) row[n++] = power(p.f, t.i) * power(p.b, t.j) * power(s, t.k);
  for (const Term& t : below)
    row[n++] = -p.share * power(p.f, t.i) * power(p.b, t.j) * power(s, t.k);
}

/// The values of numerator - share * denominator and of the denominator.
struct Value {
  real residual, denominator;
};
Value evaluate(const Point& p, const Vector& row, const Vector& x) {
  real numerator = p.f + 2 * p.b, denominator = 3 * (p.f + p.b);
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (i < above.size())
      numerator += x[i] * row[i];
    else if (p.share > 0)
      denominator -= x[i] * row[i] / p.share;
  }
  return {numerator - p.share * denominator, denominator};
}

real worst_error(const std::vector<Point>& points, const Vector& k, const Vector& x,
                 Point* at = nullptr) {
  Vector row(above.size() + below.size());
  real worst = 0;
  for (const Point& p : points) {
    fill_row(p, root(k, p.f, p.b), row);
    const Value v = evaluate(p, row, x);
    const real e = v.denominator > 0 ? std::abs(v.residual / v.denominator) * p.opacity : 1;
    if (e > worst) {
      worst = e;
      if (at) *at = p;
    }
  }
  return worst;
}

/// Minimises |dPsi| for given k, by linear least squares of numerator - share * denominator over
/// the previous denominator (Sanathanan and Koerner 1963). Weights rise where the error is large
/// (Lawson 1961).
real fit(const std::vector<Point>& points, const Vector& k, int turns, Vector& best) {
  const std::size_t n = above.size() + below.size();
  Vector weight(points.size(), 1), denominator(points.size()), row(n);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    denominator[i] = 3 * (p.f + p.b) * (1 + p.f + std::sqrt(p.b));
  }
  real least = 1;
  for (int turn = 0; turn < turns; ++turn) {
    std::vector<Vector> a(n, Vector(n));
    Vector y(n);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Point& p = points[i];
      fill_row(p, root(k, p.f, p.b), row);
      const real scale = p.opacity / denominator[i], w = weight[i] * scale * scale;
      const real target = p.share * 3 * (p.f + p.b) - (p.f + 2 * p.b);
      for (std::size_t r = 0; r < n; ++r) {
        y[r] += w * row[r] * target;
        for (std::size_t c = 0; c < n; ++c) a[r][c] += w * row[r] * row[c];
      }
    }
    const Vector x = solve(a, y);
    if (x.empty()) break;
    real worst = 0, sum = 0;
    bool positive = true;
    Vector errors(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Point& p = points[i];
      fill_row(p, root(k, p.f, p.b), row);
      const Value v = evaluate(p, row, x);
      positive = positive && v.denominator > 0;
      denominator[i] = std::max(v.denominator, 1e-3L * (p.f + p.b));
      errors[i] = std::abs(v.residual / denominator[i]) * p.opacity;
      worst = std::max(worst, errors[i]);
    }
    if (positive && worst < least) least = worst, best = x;
    if (turn < 5) continue;
    for (std::size_t i = 0; i < points.size(); ++i)
      sum += weight[i] *= std::pow(errors[i] / worst + 1e-3L, 0.6L);
    for (real& w : weight) w *= real(points.size()) / sum;
  }
  return least;
}

/// Nelder and Mead's simplex search from x. The first simplex moves each parameter by 40 %.
Vector search(const std::function<real(const Vector&)>& f, const Vector& x, int turns) {
  struct Corner {
    Vector x;
    real value;
  };
  std::vector<Corner> simplex{{x, f(x)}};
  for (std::size_t i = 0; i < x.size(); ++i) {
    Vector moved = x;
    moved[i] *= 1.4L;
    simplex.push_back({moved, f(moved)});
  }
  const auto by_value = [](const Corner& a, const Corner& b) { return a.value < b.value; };
  for (int turn = 0; turn < turns; ++turn) {
    std::stable_sort(simplex.begin(), simplex.end(), by_value);
    Corner& last = simplex.back();
    const auto at = [&](real step) {
      Vector result(x.size());
      for (std::size_t j = 0; j < x.size(); ++j) {
        real middle = 0;
        for (std::size_t i = 0; i < x.size(); ++i) middle += simplex[i].x[j] / real(x.size());
        result[j] = middle + step * (last.x[j] - middle);
      }
      return Corner{result, f(result)};
    };
    const Corner mirrored = at(-1);
    if (mirrored.value < simplex[0].value) {
      const Corner further = at(-2);
      last = further.value < mirrored.value ? further : mirrored;
    } else if (mirrored.value < simplex[x.size() - 1].value) {
      last = mirrored;
    } else if (const Corner inside = at(0.5L); inside.value < last.value) {
      last = inside;
    } else {
      for (std::size_t i = 1; i < simplex.size(); ++i) {
        for (std::size_t j = 0; j < x.size(); ++j)
          simplex[i].x[j] = (simplex[i].x[j] + simplex[0].x[j]) / 2;
        simplex[i].value = f(simplex[i].x);
      }
    }
  }
  return std::min_element(simplex.begin(), simplex.end(), by_value)->x;
}

void print_psi_fit() {
  const std::vector<Point> coarse = grid(1e-2L, 6), fine = grid(1e-3L, 40);
  Vector x;
  const auto of_k = [&](const Vector& k) { return fit(coarse, k, 40, x); };
  Vector k = search(of_k, {0.34L, 0.5L, 0.037L}, 120);
  for (real& v : k) v = std::round(std::abs(v) * 1e4L) / 1e4L;
  fit(grid(1e-2L, 12), k, 200, x);
  for (real& v : x) v = std::round(v * 1e6L) / 1e6L;
  Point at{};
  const real worst = worst_error(fine, k, x, &at);
  std::printf("\n== psi_fit.glsl ==\nmax |dPsi| over {0} and 1e-3 to 1e4: %.2Le at %.4Lg, %.4Lg\n",
              worst, at.f, at.b);
  std::printf("s = sqrt(1 + %.4Lf b + %.4Lf f + %.4Lf f^2) - 1\n", k[0], k[1], k[2]);
  const auto print = [&](const char* name, const std::vector<Term>& terms, std::size_t first) {
    std::printf("%s", name);
    for (std::size_t i = 0; i < terms.size(); ++i)
      std::printf(" %+.6Lf %s%s%s", x[first + i], std::string(std::size_t(terms[i].i), 'f').c_str(),
                  std::string(std::size_t(terms[i].j), 'b').c_str(),
                  std::string(std::size_t(terms[i].k), 's').c_str());
    std::printf("\n");
  };
  print("numerator   f + 2 b", above, 0);
  print("denominator 3 (f + b)", below, above.size());
}

}  // namespace

int main() {
  print_special_functions();
  print_psi_fit();
}
