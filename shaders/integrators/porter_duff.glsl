// A homogeneous step of the front sample: zeta = e^{-x_f}, C = L_f (1 - zeta).
// Moreland 2004, eq. 14; Porter and Duff 1984. What vdb_render, VTK and GVDB do.
Weights porter_duff(Segment s) {
  real x = s.tau_front * s.extent;
  return Weights(decay(x).a, real(0.0), real(0.0), x);
}
