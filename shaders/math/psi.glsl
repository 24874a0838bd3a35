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
  if (t < crossover) return Homogeneous(real(1.0) - series, series);
  real h = a / t;
  return Homogeneous(h, real(1.0) - h);
}
