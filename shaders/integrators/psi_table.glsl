// Psi from a table over both ends (partial pre-integration: Moreland and Angel 2004): what it holds is the back end's share (Psi - zeta)/(1 - zeta) over a factor that has
// its limits, so that thin media keep their relative precision, and constant L is exact whatever the
// table says. Bilinear in 2/(2 + sqrt(x)) of each end, not in the customary x/(1 + x), in which
// Psi ~ sqrt(pi/(2 x_b)) has an infinite slope. See src/march/march_tables.h.
const int psi_table_size = 128;  // cells on a side

// Where an end lies in the table: 0 for an endless x, psi_table_size for none.
real psi_table_place(real x) { return real(2 * psi_table_size) / (real(2.0) + sqrt(x)); }

// The share's thin limit, falling as it does like 1/x_f.
real psi_table_factor(real x_f, real x_b) {
  return (x_f + real(2.0) * x_b) / (max(x_f + x_b, real(1e-37)) * (real(3.0) + x_f));
}

Weights psi_table(Segment s) {
  Ends x = shifted_ends(s);
  real f = psi_table_place(x.front);
  real b = psi_table_place(x.back);
  int i = table_entry(f, psi_table_size - 1);
  int j = table_entry(b, psi_table_size - 1);
  f -= real(i);
  b -= real(j);
  real4 corner = fetch_table(psi_table_first + i * psi_table_size + j);
  real near = corner.x + b * (corner.y - corner.x);
  real far = corner.z + b * (corner.w - corner.z);
  real share = (near + f * (far - near)) * psi_table_factor(x.front, x.back);
  real opacity = decay(s.depth).a;
  real back = opacity * min(share, real(1.0));
  return Weights(opacity - back, real(0.0), back, s.depth);
}
