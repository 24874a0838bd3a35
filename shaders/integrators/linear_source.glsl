// The source S = L tau linear along the segment instead of L: C = S_f (Psi - M) + S_b M times the
// length, so that the weights of L are
//   w_f = x_f (Psi - M),  w_b = x_b M,  w_f + w_b = 1 - zeta.
// The smaller is taken as it is, the larger is what it leaves of 1 - zeta.
Weights linear_source(Segment s) {
  Ends x = shifted_ends(s);
  Decay d = decay(s.depth);
  LinearPsi linear = linear_psi(x.front, x.back, d.e);
  real front = x.front * linear.rest;
  real back = x.back * linear.m;
  if (front < back)
    back = d.a - front;
  else
    front = d.a - back;
  return Weights(front, real(0.0), back, s.depth);
}
