// Opacity linear along the segment, alpha = 1 - e^{-tau U} for each unit of length U (opacity_unit),
// D the length: Moreland 2004, eq. 64 and 65,
//   alpha_zeta = (alpha_b + alpha_f)/2 + 0.108165 (alpha_b - alpha_f)^2, zeta = (1 - alpha_zeta)^(D/U)
//   alpha_w    = 0.27 alpha_b + 0.73 alpha_f,      Psi = h(-(D/U) ln(1 - alpha_w)).
//
// As log-sum-exp, with m the smaller and d the difference of the two tau U, A = 1 - e^{-d}:
//   -ln(1 - alpha_zeta) = m - ln(1 - A/2 - 0.108165 e^{-m} A^2)
//   -ln(1 - alpha_w)    = m - ln(1 - w A),         w the weight of the larger end
// which are finite where both opacities round to 1. The two fits do not belong to one medium: Psi can
// fall below zeta (psi_weights).
Weights opacity_linear(Segment s) {
  real front = s.tau_front * opacity_unit;
  real back = s.tau_back * opacity_unit;
  real units = s.extent / opacity_unit;
  real m = min(front, back);
  real a = decay(abs(front - back)).a;
  real v = a * (real(0.5) + real(0.108165) * decay(m).e * a);  // at most 0.61
  real depth = units * (m + minus_log_1m(v));
  real t = units * (m + minus_log_1m((front < back ? real(0.27) : real(0.73)) * a));
  Decay d = decay(depth);
  return psi_weights(homogeneous(t, decay(t).a), d.e, d.a, depth);
}
