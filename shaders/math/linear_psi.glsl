// The integrals over a segment of linear attenuation, without cancellation: with
// g(u) = x_f u + (x_b - x_f) u^2/2,
struct LinearPsi {
  real psi;   // Psi = integral of e^{-g} over [0, 1]
  real m;     // M = integral of u e^{-g}
  real rest;  // Psi - M
  real back;  // Psi - zeta
};

// Both ends below 1: J_k = integral of u^k e^{-g} by parts, downwards,
//   (k + 1) J_k = zeta + x_f J_{k+1} + (x_b - x_f) J_{k+2}.
// It begins with J_k = zeta/(k + 1 - x_b), off by a few 1/k^2 of itself; J_1 keeps 1/(3 5 7 ... k - 1)
// of that at most (x_f = 0): 1e-8 in float32, 1e-17 in double. Psi - zeta = x_f (J_1 - J_2) + x_b J_2.
LinearPsi thin_psi(real x_f, real x_b, real zeta) {
  real d = x_b - x_f;
#if REAL_BITS == 64
  real even = zeta / (real(27.0) - x_b);
  real odd = zeta / (real(26.0) - x_b);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 25.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 24.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 23.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 22.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 21.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 20.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 19.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 18.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 17.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 16.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 15.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 14.0);
#else
  real even = zeta / (real(15.0) - x_b);
  real odd = zeta / (real(14.0) - x_b);
#endif
  even = (zeta + x_f * odd + d * even) * real(1.0 / 13.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 12.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 11.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 10.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 9.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 8.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 7.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 6.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 5.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 4.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 3.0);
  odd = (zeta + x_f * even + d * odd) * real(0.5);
  real psi = zeta + x_f * odd + d * even;
  return LinearPsi(psi, odd, psi - odd, x_f * (odd - even) + x_b * even);
}

// Else what begins at the front less what begins at the back, behind the transparency zeta:
//   Psi = V_f - zeta V_b,  M = U_f - zeta (U_b + V_b)
// (scaled erfc where attenuation grows, Dawson's integral where it falls: Williams, Max and Stein
// 1998). Neither difference loses more than a factor 10 where an end is 1 or more.
LinearPsi linear_psi(real x_f, real x_b, real zeta) {
  if (max(x_f, x_b) < real(1.0)) return thin_psi(x_f, x_b, zeta);
  real w = sqrt(real(2.0) * abs(x_b - x_f));
  bool grows = x_b >= x_f;
  Tail front = grows ? growing_tail(x_f, w) : falling_tail(x_f, w);
  Tail back = grows ? growing_tail(x_b, w) : falling_tail(x_b, w);
  real psi = front.v - zeta * back.v;
  real m = front.u - zeta * (back.u + back.v);
  return LinearPsi(psi, m, psi - m, psi - zeta);
}
