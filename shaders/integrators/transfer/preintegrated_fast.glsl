// The transfer function between two values by integral functions: the optical depth is exact for values
// that are linear along the segment, and the luminance is its mean weighted by attenuation, as if
// the segment did not shade itself. Engel, Kraus and Ertl 2001, sec. 3 (their K and the table
// without self-attenuation), with the opacity kept exact: constant L gives L (1 - T).
Mixture preintegrated_fast(real front, real back, real length) {
  Average mean = transfer_average(front, back);
  real none = real(1e-30);
  return Mixture(extinction * length * mean.attenuation,
                 mean.source * (real(1.0) / max(mean.attenuation, none)));
}
