// Weighted opacity: Psi = h(t), t = -ln(0.27 e^{-x_b} + 0.73 e^{-x_f}), C = L_f (1 - Psi)
// + L_b (Psi - zeta). Moreland 2004, eq. 65 (weights) and 53 to 56 (use).
//
// With m = min(x_f, x_b), d = |x_f - x_b| and w the weight of the larger end, as log-sum-exp:
//   t = m - ln(1 - w (1 - e^{-d}))     finite where both opacities round to 1
// and from the same two exponentials, with r = e^{-d/2}, all without cancellation in thin media:
//   1 - e^{-t} = (1 - e^{-m}) + e^{-m} w (1 - e^{-d})
//   1 - zeta   = (1 - e^{-m}) + e^{-m} (1 - e^{-d})/(1 + r),   zeta = e^{-m} r
Weights psi_weighted(Segment s) {
  Ends x = shifted_ends(s);
  real m = min(x.front, x.back);
  Decay near = decay(m);
  Decay apart = decay(abs(x.front - x.back));
  real v = (x.front < x.back ? real(0.27) : real(0.73)) * apart.a;
  real r = sqrt(apart.e);
  real opacity = near.a + near.e * apart.a / (real(1.0) + r);
  Homogeneous psi = homogeneous(m + minus_log_1m(v), near.a + near.e * v);
  return psi_weights(psi, near.e * r, opacity, s.depth);
}
