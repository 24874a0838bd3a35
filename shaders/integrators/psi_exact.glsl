// Psi of linear attenuation, exactly: C = L_f (1 - Psi) + L_b (Psi - zeta). Moreland 2004, eq. 53 to
// 56; Williams, Max and Stein 1998. 1 - Psi is at least a third of 1 - zeta, so it is left over.
Weights psi_exact(Segment s) {
  Ends x = shifted_ends(s);
  Decay d = decay(s.depth);
  real back = clamp(linear_psi(x.front, x.back, d.e).back, real(0.0), d.a);
  return Weights(d.a - back, real(0.0), back, s.depth);
}
