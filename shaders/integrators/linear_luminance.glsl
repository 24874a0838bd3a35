// Linear luminance in a homogeneous medium of the mean attenuation: Psi = h((x_f + x_b)/2).
// Moreland 2004, section 1.3 and fig. 1.10b; Max 1995.
Weights linear_luminance(Segment s) {
  Decay d = decay(s.depth);
  return psi_weights(homogeneous(s.depth, d.a), d.e, d.a, s.depth);
}
