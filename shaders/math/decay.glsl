// e^{-x} and 1 - e^{-x} together, x >= 0, each with a relative error of a few 1e-7 in float32:
// no difference of numbers near 1 is formed where x is small, and drivers' exp (6.6e-7 on llvmpipe)
// is not used, so every machine rounds alike.
struct Decay {
  real e;  // e^{-x}
  real a;  // 1 - e^{-x}
};

#if REAL_BITS == 64
Decay decay(real x) { return Decay(exp(-x), -expm1(-x)); }

real shallow_decay(real x) { return exp(-x); }

// -ln(1 - v), 0 <= v <= 0.75
real minus_log_1m(real v) { return -log1p(-v); }
#else
// Polynomials are summed in pairs (Estrin), since a turn waits for the longest chain of operations.
//
// e^{-x} = 2^n (1 + q) with -x = n ln 2 + r, |r| <= ln(2)/2, q = e^r - 1 by its Taylor series,
// whose first term left out is r^8/8! = 5e-9. With s = 2^n: 1 - e^{-x} = (1 - s) - s q, exact
// subtraction; n = 0 below x = 0.35, where it is -q itself. `precise`: else
// NVIDIA's compiler computes 1 - e.
Decay decay(real x) {
  real y = min(x, real(87.0));  // e^{-87} = 1.6e-38, the smallest normal number
  real n = floor(real(0.5) - y * real(1.44269504));
  // ln 2 in two parts, the first of 12 bits, so that n times it is exact
  real r = (-y - n * real(0.693359375)) - n * real(-2.12194440e-4);
  real r_2 = r * r;
  real q = r * (((real(1.0) + r * real(0.5)) + r_2 * (real(0.166666667) + r * real(0.0416666667)))
         + (r_2 * r_2) * ((real(8.33333333e-3) + r * real(1.38888889e-3)) + r_2 * real(1.98412698e-4)));
  real s = power_of_two(int(n));
  precise real a = (real(1.0) - s) - s * q;
  return Decay(s + s * q, a);
}

// e^{-x}, 0 <= x <= 1.5, and beyond as at 1.5: half of decay's instructions. The polynomial that
// meets it in seven Chebyshev nodes is off by 2e-7 of it, by 9e-7 with float32's rounding.
real shallow_decay(real x) {
  real y = min(x, real(1.5));
  real y_2 = y * y;
  return ((real(1.0) - y * real(0.999999971)) + y_2 * (real(0.499998081) - y * real(0.166646009)))
       + (y_2 * y_2) * ((real(0.0415825104) - y * real(0.00816779183))
                        + y_2 * (real(0.00121733348) - y * real(0.000104694461)));
}

// -ln(1 - v), 0 <= v <= 0.75, relative error of a few 1e-7 (llvmpipe's log has 7.5e-5):
// -ln(1 - v) = 2 atanh(v / (2 - v)); above v = 0.48 the argument is first scaled by 1.92, so that
// |z| <= 0.351 and the first term left out of the series, z^14/15, is 3e-8.
real minus_log_1m(real v) {
  bool far = v > real(0.48);
  real y = (real(1.0) - v) * real(1.92);
  real z = far ? (real(1.0) - y) / (real(1.0) + y) : v / (real(2.0) - v);
  real q = z * z;
  real series = real(1.0) + q * (real(0.333333333) + q * (real(0.2) + q * (real(0.142857143)
              + q * (real(0.111111111) + q * (real(0.0909090909) + q * real(0.0769230769))))));
  return real(2.0) * z * series + (far ? real(0.652325186) : real(0.0));
}
#endif

// e^{-8x}, 0 <= x <= 1.5, off by 5e-7 of 1 in float32: the eighth power rounds eight times. At most 1
// below 0, where rounding may bring x, by much if the extinction is great.
real deep_decay(real x) {
  real e = shallow_decay(abs(x));
  e *= e;
  e *= e;
  return e * e;
}

// Psi of a homogeneous step and its complement: h(t) = (1 - e^{-t})/t, h(0) = 1 (docs/method.md).
struct Homogeneous {
  real h;            // Psi
  real one_minus_h;  // 1 - Psi, never formed as that difference where t is small
};

// 1 - h(t) = (t - 1 + e^{-t})/t. Below the crossover the series t/2 - t^2/6 + ..., above it
// 1 - a/t, whose cancellation costs a factor h/(1 - h): 3.7 at 1/2 (float32), 66 at 0.03 (double),
// where the first term left out of the series is 1e-16 of it.
// `a` is 1 - e^{-t}, which callers have at hand.
Homogeneous homogeneous(real t, real a) {
#if REAL_BITS == 64
  real crossover = real(0.03);
#else
  real crossover = real(0.5);
#endif
  real series = t * (real(0.5) - t * (real(1.0) / real(6.0) - t * (real(1.0) / real(24.0)
              - t * (real(1.0) / real(120.0) - t * (real(1.0) / real(720.0)
              - t * (real(1.0) / real(5040.0) - t * real(1.0 / 40320.0)))))));
  real h = a / t;
  return Homogeneous(t < crossover ? real(1.0) - series : h, t < crossover ? series : real(1.0) - h);
}
