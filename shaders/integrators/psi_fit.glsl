// Psi of linear attenuation as a rational function of both ends and one root, found by
// tools/fit_psi.py: |dPsi| <= 8.5e-4 for all ends up to 1e4, no exponential but zeta's. It is the back
// end's share (Psi - zeta)/(1 - zeta) that is fitted, with its exact limit (x_f + 2 x_b)/(3 (x_f + x_b))
// of thin media, so that constant L stays exact.
Weights psi_fit(Segment s) {
  Ends x = shifted_ends(s);
  real f = min(x.front, real(1e8));  // whose cube is still a float32
  real b = min(x.back, real(1e8));
  real q = real(0.3738) * b + f * (real(0.5328) + real(0.0375) * f);
  real r = q / (real(1.0) + sqrt(real(1.0) + q));
  real above = f + real(2.0) * b
             + f * (real(0.345343) * f + real(0.815876) * b - real(1.143334) * r)
             + b * (real(0.455369) * b - real(2.272895) * r);
  real below = real(3.0) * (f + b)
             + f * f * (real(0.466875) + real(0.415508) * f + real(0.591993) * b
                        - real(1.439001) * r)
             + f * b * (real(0.292564) * b - real(0.852725) * r)
             + b * (r * (real(2.591726) + real(0.572693) * b) - real(0.288136) * b);
  real opacity = decay(s.depth).a;
  real back = opacity * clamp(above / max(below, real(1e-37)), real(0.0), real(1.0));
  return Weights(opacity - back, real(0.0), back, s.depth);
}
