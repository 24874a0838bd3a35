// The mean luminance of the ends: w = (1 - zeta)/2 each. Moreland 2004, fig. 1.10a.
Weights average(Segment s) {
  real w = real(0.5) * decay(s.depth).a;
  return Weights(w, real(0.0), w, s.depth);
}
