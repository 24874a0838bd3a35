// Pre-integration (Engel, Kraus and Ertl 2001): the transfer function applied inside a segment along
// which the value is linear. The optical depth and what the mean luminance would be without
// self-attenuation are in closed form; what self-attenuation adds to it is in a table over both
// ends and the length, see src/march/preintegration.h.
real3 shading_entry(int layer, int i, int j) {
  int diagonal = j < i ? j - i + preintegration_size : j - i;
  return real3(fetch_table(preintegration_first
                           + (layer * preintegration_size + diagonal) * preintegration_size + i));
}

// Linear on triangles whose long sides run along diagonals: exactly 0 for equal ends.
real3 shading_layer(int layer, int i, int j, real u, real v) {
  if (layer < 0) return real3(real(0.0));
  int p = u < v ? i : i + 1;
  int q = u < v ? j + 1 : j;
  return shading_entry(layer, i, j) * (real(1.0) - max(u, v))
       + shading_entry(layer, i + 1, j + 1) * min(u, v)
       + shading_entry(layer, p, q) * abs(u - v);
}

// How the shading grows with a segment's optical depth, from x/6 to 1 - 2/x: coth(x/2) - 2/x, which
// it is for constant attenuation and linear colour, by a rational function.
real saturation(real x) {
  real y = min(x, real(1e9));  // whose square float32 holds
  return y * (y + real(4.0)) / (y * (y + real(6.0)) + real(24.0));
}

real layer_length(int layer) {
  real z = real(layer) / real(preintegration_layers);
  return preintegration_length * z * z;
}

// Values between the knots; `attenuation`: their mean, times the extinction. Between two layers it
// is linear in what the optical depth makes of it.
real3 shading(real front, real back, real length, real attenuation) {
  real most = real(preintegration_size - 1);
  real x = clamp((front - transfer_min) * preintegration_scale, real(0.0), most);
  real y = clamp((back - transfer_min) * preintegration_scale, real(0.0), most);
  int i = table_entry(x, preintegration_size - 2);
  int j = table_entry(y, preintegration_size - 2);
  real z = sqrt(max(length / preintegration_length, real(0.0)));
  int layer = table_entry(z * real(preintegration_layers), preintegration_layers - 1);
  real before = saturation(attenuation * layer_length(layer));
  real behind = saturation(attenuation * layer_length(layer + 1));
  real w = clamp((saturation(attenuation * length) - before) / max(behind - before, real(1e-30)),
                 real(0.0), real(1.0));
  return shading_layer(layer - 1, i, j, x - real(i), y - real(j)) * (real(1.0) - w)
       + shading_layer(layer, i, j, x - real(i), y - real(j)) * w;
}

// What lies outside the knots is constant: the segment is three in a row, of which the middle one
// is in the table and the others have closed forms.
Mixture preintegrated(real front, real back, real length) {
  real first = knot_value(0);
  real last = knot_value(knots() - 1);
  real f = clamp(front, first, last);
  real b = clamp(back, first, last);
  real range = abs(back - front);
  // shares of the length; both ends may lie on one side
  real scale = range > real(0.0) ? real(1.0) / range : real(0.0);
  real near = min(abs(f - front) * scale, real(1.0));
  real far = min(abs(back - b) * scale, real(1.0) - near);
  real inside = (range > real(0.0) ? abs(b - f) * scale : real(1.0)) * length;
  Average mean = transfer_average(f, b);
  Classified c = classify(f);
  Classified d = classify(b);
  real x_near = extinction * length * near * c.attenuation;
  real x_inside = extinction * inside * mean.attenuation;
  real x_far = extinction * length * far * d.attenuation;
  real none = real(1e-30);
  real3 L = mean.source * (real(1.0) / max(mean.attenuation, none))
          + shading(f, b, inside, extinction * mean.attenuation);
  Decay before = decay(x_near);
  Decay between = decay(x_inside);
  real w_inside = before.e * between.a;
  real w_far = before.e * between.e * decay(x_far).a;
  real sum = before.a + w_inside + w_far;
  real3 C = c.color * before.a + max(L, real3(real(0.0))) * w_inside + d.color * w_far;
  return Mixture(x_near + x_inside + x_far, C * (real(1.0) / max(sum, none)));
}
