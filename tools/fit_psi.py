#!/usr/bin/env python3
"""Computes the constants of shaders/math/linear_psi.glsl, shaders/math/linear_psi.glsl and
shaders/integrators/psi_fit.glsl (Debian: python3-numpy).

It prints them as they appear there, with the largest error of each. It is deterministic, and
computes in numpy's longdouble, which must have 64 bits of mantissa or more."""

import numpy as np

real = np.longdouble
PI = real("3.14159265358979323846264338327950288")


def total(values):
    """The sum over the last axis, in its order: numpy's own order would change last digits."""
    return np.add.accumulate(values, axis=-1)[..., -1]


# --- the functions --------------------------------------------------------------------------------

def mills(p):
    """e = sqrt(pi) erfcx(p) = 2 int_0^inf e^{-t^2-2pt} dt and c = 1 - p e = 2 int t e^{-t^2-2pt} dt.

    By the trapezoidal rule after t = s e^{u - e^{-u}} (exp-sinh), which converges exponentially."""
    h, p = real(1) / 32, np.atleast_1d(np.asarray(p, real))[:, None]
    u = h * np.arange(-160, 121).astype(real)
    shrink = np.exp(-u)
    t = 1 / (1 + p) * np.exp(u - shrink)
    w = 2 * h * t * (1 + shrink) * np.exp(-t * (t + 2 * p))
    return total(w), total(w * t)


def dawson(x):
    """Dawson's integral F = e^{-x^2} int_0^x e^{t^2} dt and n = 2 x F - 1, by a series of positive
    terms. From x = 12 on, n uses its asymptotic series, whose smallest term is e^{-144}."""
    x = np.atleast_1d(np.asarray(x, real))
    near = np.where(x > 12, real(1), x)
    f, term = np.zeros_like(near), near.copy()
    for k in range(2000):
        f += term / (2 * k + 1)
        term = term * (near * near / (k + 1))
    f *= np.exp(-near * near)
    n = 2 * near * f - 1
    v = 1 / (2 * np.where(x > 12, x, real(12)) ** 2)
    term, far, k = v.copy(), np.zeros_like(v), 1
    while np.any(term > real("1e-22") * far):
        going = term > real("1e-22") * far
        far = np.where(going, far + term, far)
        term = np.where(going, term * ((2 * k + 1) * v), 0)
        k += 1
    return np.where(x > 12, (1 + far) / (2 * np.maximum(x, 1)), f), np.where(x > 12, far, n)


def share_of_back(f, b):
    """(Psi - zeta)/(1 - zeta): the back end's share of the light from a segment of linear
    attenuation."""
    zeta, opacity = np.exp(-(f + b) / 2), -np.expm1(-(f + b) / 2)
    # as in shaders/math/linear_psi.glsl; 4^70/70! = 1e-58
    above, j = zeta / 70, zeta / 69
    for k in range(68, 0, -1):
        above, j = j, (zeta + f * j + (b - f) * above) / (k + 1)
    share = (f * (j - above) + b * above) / opacity
    psi = np.zeros_like(f)
    for kind, where in (("same", f == b), ("rising", b > f), ("falling", b < f)):
        where &= np.maximum(f, b) > 4
        F, B, Z = f[where], b[where], zeta[where]
        if kind == "same":
            psi[where] = opacity[where] / F
        elif kind == "rising":
            w = np.sqrt(2 * (B - F))
            psi[where] = (mills(F / w)[0] - Z * mills(B / w)[0]) / w
        else:
            w = np.sqrt(2 * (F - B))
            psi[where] = 2 * (dawson(F / w)[0] - Z * dawson(B / w)[0]) / w
    return np.where(np.maximum(f, b) <= 4, share, (psi - zeta) / opacity)


# --- polynomials ----------------------------------------------------------------------------------

def chebyshev(f, degree):
    """Coefficients of y^0, y^1, ... of f's Chebyshev expansion over [-1, 1], cut off at `degree`."""
    n = 128
    places = np.arange(n).astype(real) + real("0.5")
    values = f(np.cos(PI * places / n))
    result = np.zeros(degree + 1, real)
    before, now = np.array([1], real), np.array([0, 1], real)
    for j in range(degree + 1):
        c = total(values * np.cos(PI * j * places / n) * (2 if j else 1) / n)
        t = now if j else before
        result[:len(t)] += c * t
        if j == 0:
            continue
        following = np.append(real(0), 2 * now)  # T_{j+1} = 2 y T_j - T_{j-1}
        following[:len(before)] -= before
        before, now = now, following
    return result


def number(value, digits):
    return np.format_float_scientific(value, precision=digits - 1, unique=False, exp_digits=2)


def print_polynomial(name, f, degree, digits):
    c = chebyshev(f, degree)
    y = -np.cos(PI * np.arange(1001).astype(real) / 1000)
    value = np.zeros_like(y)
    for k in range(degree, -1, -1):
        value = value * y + c[k]
    worst = np.abs(value / f(y) - 1).max()
    print(f"// {name}, degree {degree}, relative error {number(worst, 2)}")
    print(f"  real s = real({number(c[degree], digits)});")
    per_line, k = (2 if digits > 10 else 4), degree
    while k > 0:
        count = min(per_line, k)
        terms = [f"real({number(c[k - 1 - i], digits)})" for i in range(count)]
        k -= count
        print("  s = " + "(" * (count - 1) + "y * s + " + ") * y + ".join(terms) + ";")


def print_special_functions():
    def rho(y):  # r = 1/e - p = c/e: two of its values at either end of p are 1/2
        y = np.asarray(y, real)
        last = y > 1 - real("1e-15")
        p = 3 * (1 + y) / np.where(last, 1, 1 - y)
        e, c = mills(p)
        return np.where(last, real("0.5"), c / e * (p + np.sqrt(PI) / 2))

    def small(y):
        x = np.sqrt(2 * (1 + np.asarray(y, real)))
        tiny = x < real("1e-9")
        return np.where(tiny, 1, dawson(x)[0] / np.where(tiny, 1, x))

    def middle(y):
        x = 3 + np.asarray(y, real)
        return 2 * x * x * dawson(x)[1]

    def large(y):
        v = (1 + np.asarray(y, real)) / 32
        tiny = v < real("1e-15")
        v = np.where(tiny, 1, v)
        return np.where(tiny, 1, 2 / v * dawson(1 / np.sqrt(v))[1])

    for single in (True, False):
        digits = 9 if single else 17
        print(f"\n== {32 if single else 64} bits ==")
        print_polynomial("mills.glsl, y = (p - 3)/(p + 3)", rho, 12 if single else 22, digits)
        print_polynomial("dawson.glsl, F/x below 2, y = x^2/2 - 1", small, 10 if single else 17,
                         digits)
        print_polynomial("dawson.glsl, 2 x^2 N of 2 to 4, y = x - 3", middle, 12 if single else 20,
                         digits)
        print_polynomial("dawson.glsl, 2 x^2 N from 4 on, y = 32/x^2 - 1", large,
                         7 if single else 22, digits)


# --- psi_fit --------------------------------------------------------------------------------------

# monomials f^i b^j s^k as (i, j, k)
ABOVE = [(2, 0, 0), (1, 1, 0), (0, 2, 0), (1, 0, 1), (0, 1, 1)]
BELOW = [(2, 0, 0), (0, 2, 0), (0, 1, 1), (2, 0, 1), (1, 1, 1), (0, 2, 1), (3, 0, 0), (2, 1, 0),
         (1, 2, 0)]


class Points:
    """Pairs of ends, 0 and from `first` to 1e4, and what the fit should give there."""

    def __init__(self, first, per_decade):
        count = int(np.rint(np.log10(1e4 / first) * per_decade))
        first = real(str(first))
        xs = np.append(real(0), first * (real(10000) / first)
                       ** (np.arange(count + 1).astype(real) / count))
        f, b = (a.ravel()[1:] for a in np.meshgrid(xs, xs, indexing="ij"))
        self.f, self.b, self.share = f, b, share_of_back(f, b)
        self.opacity = -np.expm1(-(f + b) / 2)

    def rows(self, k):
        """The terms of numerator and denominator; the denominator's are multiplied by -share."""
        k = np.abs(k)
        s = np.sqrt(1 + k[0] * self.b + k[1] * self.f + k[2] * self.f * self.f) - 1
        terms = [self.f ** i * self.b ** j * s ** n for i, j, n in ABOVE + BELOW]
        return np.array(terms[:len(ABOVE)] + [-self.share * t for t in terms[len(ABOVE):]]), terms

    def errors(self, k, x):
        """The fit's |dPsi|, and its denominator."""
        rows, terms = self.rows(k)
        denominator = 3 * (self.f + self.b)
        for factor, term in zip(x[len(ABOVE):], terms[len(ABOVE):]):
            denominator = denominator + factor * term
        target = self.share * 3 * (self.f + self.b) - (self.f + 2 * self.b)
        least = np.where(denominator > 0, denominator, 1)
        error = np.abs((np.tensordot(x, rows, 1) - target) / least) * self.opacity
        return np.where(denominator > 0, error, 1), denominator


def solve(a, y):
    """Solves with A by Cholesky; None if A is not positive definite."""
    scale = 1 / np.sqrt(np.diag(a))
    a, y, n = a * np.outer(scale, scale), y * scale, len(y)
    for i in range(n):
        for j in range(i + 1):
            rest = a[i, j] - (a[i, :j] * a[j, :j]).sum()
            if i == j and not rest > 0:
                return None
            a[i, j] = np.sqrt(rest) if i == j else rest / a[j, j]
        y[i] = (y[i] - (a[i, :i] * y[:i]).sum()) / a[i, i]
    for i in range(n - 1, -1, -1):
        y[i] = (y[i] - (a[i + 1:, i] * y[i + 1:]).sum()) / a[i, i]
    return y * scale


def fit(points, k, turns):
    """Minimises |dPsi| for given k, by linear least squares of numerator - share * denominator over
    the previous denominator (Sanathanan and Koerner 1963). Weights rise where the error is large
    (Lawson 1961). Returns the least error and its coefficients."""
    f, b = points.f, points.b
    rows = points.rows(k)[0]
    target = points.share * 3 * (f + b) - (f + 2 * b)
    weight = np.ones_like(f)
    denominator = 3 * (f + b) * (1 + f + np.sqrt(b))
    least, best = real(1), None
    for turn in range(turns):
        weighted = rows * (weight * (points.opacity / denominator) ** 2)
        x = solve(np.array([[(r * c).sum() for c in rows] for r in weighted]),
                  (weighted * target).sum(axis=1))
        if x is None:
            break
        plain = points.errors(k, x)[1]
        denominator = np.maximum(plain, real("1e-3") * (f + b))
        errors = np.abs((np.tensordot(x, rows, 1) - target) / denominator) * points.opacity
        worst = errors.max()
        if np.all(plain > 0) and worst < least:
            least, best = worst, x
        if turn < 5:
            continue
        weight = weight * (errors / worst + real("1e-3")) ** real("0.6")
        weight = weight * len(weight) / weight.sum()
    return least, best


def search(f, x, turns):
    """Nelder and Mead's simplex search from x. The first simplex moves each parameter by 40 %."""
    simplex = [(f(x), x)]
    for i in range(len(x)):
        moved = x.copy()
        moved[i] *= real("1.4")
        simplex.append((f(moved), moved))
    for _ in range(turns):
        simplex.sort(key=lambda corner: corner[0])
        middle = sum(corner[1] for corner in simplex[:-1]) / len(x)

        def at(step):
            place = middle + step * (simplex[-1][1] - middle)
            return f(place), place

        mirrored = at(real(-1))
        if mirrored[0] < simplex[0][0]:
            simplex[-1] = min(at(real(-2)), mirrored, key=lambda corner: corner[0])
        elif mirrored[0] < simplex[-2][0]:
            simplex[-1] = mirrored
        else:
            inside = at(real("0.5"))
            if inside[0] < simplex[-1][0]:
                simplex[-1] = inside
            else:
                halves = [(x + simplex[0][1]) / 2 for _, x in simplex[1:]]
                simplex[1:] = [(f(x), x) for x in halves]
    return min(simplex, key=lambda corner: corner[0])[1]


def print_psi_fit():
    coarse, fine = Points(1e-2, 6), Points(1e-3, 40)
    k = search(lambda k: fit(coarse, k, 40)[0], np.array(["0.34", "0.5", "0.037"]).astype(real), 120)
    k = np.rint(np.abs(k) * 10000) / 10000
    x = np.rint(fit(Points(1e-2, 12), k, 200)[1] * 1000000) / 1000000
    errors = fine.errors(k, x)[0]
    at = errors.argmax()
    print(f"\n== psi_fit.glsl ==\nmax |dPsi| over {{0}} and 1e-3 to 1e4: {number(errors[at], 3)} at "
          f"{float(fine.f[at]):.4g}, {float(fine.b[at]):.4g}")
    print(f"s = sqrt(1 + {k[0]:.4f} b + {k[1]:.4f} f + {k[2]:.4f} f^2) - 1")
    for name, terms, values in (("numerator   f + 2 b", ABOVE, x),
                                ("denominator 3 (f + b)", BELOW, x[len(ABOVE):])):
        print(name + "".join(f" {float(value):+.6f} {'f' * i}{'b' * j}{'s' * n}"
                             for value, (i, j, n) in zip(values, terms)))


print_special_functions()
print_psi_fit()
