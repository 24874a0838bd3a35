// Weights balanced against the bias of a lattice of linear L times linear tau: with e = e^{-x/2},
// a = 1 - e, p = 1 - (x/2)/sinh(x/2) of each end and p' = min((p_f + p_b)/2, a_b):
//   w_f = a_f + e_f p',  w_b = e_f (a_b - p'),  zeta = e_f e_b.
// Fourth order on smooth fields from vacuum to vacuum; see docs/method.md.
real balance(Decay d, real x) {  // 1 - y/sinh(y) of y = x/2, d = decay(y)
  real y = real(0.5) * x;
  real q = y * y;
#if REAL_BITS == 64
  if (y < real(0.05))  // first term left out 73 y^10 / 3421440: 2e-18
#else
  if (y < real(0.5))  // the same: 2e-8
#endif
    return q * (real(1.0 / 6.0) - q * (real(7.0 / 360.0) - q * (real(31.0 / 15120.0)
         - q * real(127.0 / 604800.0))));
  return real(1.0) - real(2.0) * y * d.e / (d.a * (real(1.0) + d.e));
}

Weights psi_balanced(Segment s) {
  Ends x = shifted_ends(s);
  Decay front = decay(real(0.5) * x.front);
  Decay back = decay(real(0.5) * x.back);
  real p = min(real(0.5) * (balance(front, x.front) + balance(back, x.back)), back.a);
  return Weights(front.a + front.e * p, real(0.0), front.e * (back.a - p), s.depth);
}
