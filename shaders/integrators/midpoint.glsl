// A homogeneous step of the sample in the middle: zeta = e^{-x_m}, C = L_m (1 - zeta).
Weights midpoint(Segment s) {
  real x = s.tau_middle * s.extent;
  return Weights(real(0.0), decay(x).a, real(0.0), x);
}
