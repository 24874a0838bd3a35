// The transfer function: what a value of the density grid means. Piecewise linear between knots and
// constant outside; how `tables` holds it is documented in src/march/transfer_table.h.
// What it is asked of: a value, and the gradient's magnitude [value/world unit], which is 0 and not
// looked at unless
// `with_gradient`.
struct Sample {
  real value;
  real gradient;
};

struct Classified {
  real attenuation;  // factor of the extinction
  real3 color;       // factor of the luminance
};

const int knot_entries = 4;  // a knot

int knots() { return one_interval ? 2 : transfer_knots; }

real4 knot_entry(int k, int part) {
  int i = knot_entries * k + part;
  if (one_interval) return fetch_interval(i);
  return fetch_table(transfer_first + i);
}
real4 knot_head(int k) { return knot_entry(k, 0); }
real knot_value(int k) { return knot_head(k).x; }
real4 knot_color_entry(int k) { return knot_entry(k, 1); }
real3 knot_color(int k) { return real3(knot_color_entry(k)); }
// Integrals from the first knot to this one, over the function's range: of the attenuation, and of it
// times the colour.
real range_unit() { return transfer_bin_scale / real(transfer_bins); }
real knot_integral(int k) { return knot_color_entry(k).w; }
real3 knot_color_integral(int k) { return real3(knot_entry(k, 3)); }

// From knot k to the next one: `change` and `color_change` are rounded to float32 in the table.
struct Interval {
  real value;
  real attenuation;
  real width;
  real change;
};
#if REAL_BITS == 64
Interval interval_of(int k) {
  real4 a = knot_head(k);
  real4 b = knot_head(k + 1);
  return Interval(a.x, a.y, b.x - a.x, b.y - a.y);
}
real3 color_change(int k) { return knot_color(k + 1) - knot_color(k); }
#else
Interval interval_of(int k) {
  real4 a = knot_head(k);
  return Interval(a.x, a.y, a.z, a.w);
}
real3 color_change(int k) { return real3(knot_entry(k, 2)); }
#endif

// The last k with knot k <= value, kept such that k + 1 is a knot too.
int transfer_interval(real value) {
  if (one_interval) return 0;
  real x = (value - transfer_min) * transfer_bin_scale;
  int bin = table_entry(x, transfer_bins - 1);
  real4 range = fetch_table(transfer_bins_first + bin);
  int lo = int(range.x);
  int hi = int(range.y);
  if (!transfer_search) return value >= range.z ? hi : lo;
  while (lo < hi) {
    int middle = (lo + hi + 1) >> 1;
    if (knot_value(middle) <= value) lo = middle;
    else hi = middle - 1;
  }
  return lo;
}

Classified classify_in(int k, real value) {
  Interval a = interval_of(k);
  real u = clamp((value - a.value) / a.width, real(0.0), real(1.0));
  real3 at = knot_color(k);
  if (luminance_source == SOURCE_TRANSFER || lit_colors) at = at + color_change(k) * u;
  return Classified(a.attenuation + a.change * u, at);
}

// The column of the table of gradients: the last j with gradient j <= g, kept inside. All rays take the
// same turns: llvmpipe of Mesa 26.1 never leaves a search in a loop that they end at different turns.
int gradient_column(real g) {
  int j = 0;
  int stride = 1;
  while (2 * stride < gradient_columns) stride *= 2;
  for (; stride > 0; stride >>= 1) {
    int next = j + stride;
    if (next < gradient_columns && real(fetch_table(gradient_first + next).x) <= g) j = next;
  }
  return j;
}

// Bilinear in interval k of the values, and what isosurfaces add: Levoy 1988, eq. 3.
real gradient_attenuation(int k, Sample s) {
  int j = gradient_column(s.gradient);
  real4 ends = fetch_table(gradient_first + j);
  real4 a = fetch_table(gradient_first + gradient_columns * (k + 1) + j);
  real lo = knot_value(k);
  real u = clamp((s.value - lo) / (knot_value(k + 1) - lo), real(0.0), real(1.0));
  real w = clamp((s.gradient - ends.x) / (ends.y - ends.x), real(0.0), real(1.0));
  real sum = mix(mix(a.x, a.y, w), mix(a.z, a.w, w), u);
  for (int i = 0; i < isosurfaces; ++i) {
    real4 surface = fetch_table(isosurfaces_first + i);
    real d = abs(s.value - surface.x);
    real reach = surface.y * s.gradient;
    real share = d < reach ? real(1.0) - d / reach : d > real(0.0) ? real(0.0) : real(1.0);
    sum += surface.z * share;
  }
  return sum;
}

// The attenuation as a constant and four ramps, each 0 up to its knot and linear from there on.
real4 ramps_at(real value) {
  return max(real4(value, value, value, value) - ramp_knots,
             real4(real(0.0), real(0.0), real(0.0), real(0.0)));
}
real ramp_sum(real4 values) { return ramp_base + dot(values, ramp_slopes); }

Classified classify(Sample s) {
  if (ramps) return Classified(ramp_sum(ramps_at(s.value)), real3(real(1.0)));
  int k = transfer_interval(s.value);
  Classified c = classify_in(k, s.value);
  if (with_gradient) c.attenuation = gradient_attenuation(k, s);
  return c;
}
Classified classify(real value) { return classify_in(transfer_interval(value), value); }

// A piece in interval k, -1 before all knots, knots() - 1 behind them, has the function of this one,
int interval_within(int k) { return one_interval ? 0 : clamp(k, 0, knots() - 2); }
// of this value: by rounding it may lie beyond the interval.
real value_within(int k, real value) {
  real far = real(3e38);
  return k < 0 ? -far : k > knots() - 2 ? far : value;
}

Classified classify_within(int k, real value) {
  return classify_in(interval_within(k), value_within(k, value));
}

// The colour of a piece whose value differs from channel to channel.
real3 colors_within(int k, real3 values) {
  int at = interval_within(k);
  Interval a = interval_of(at);
  real3 v = real3(value_within(k, values.x), value_within(k, values.y), value_within(k, values.z));
  real3 u = clamp((v - a.value) / a.width, real3(real(0.0)), real3(real(1.0)));
  return knot_color(at) + color_change(at) * u;
}

// The first part of a cubic of values that is monotone and stays between two knots, where the
// attenuation is a + b value.
struct Piece {
  real part;
  real a;
  real b;
  int interval;
};

// `noise`: what rounding makes of the values. An interval holds as much beyond its knots, or a value
// that stays on a knot, or hardly turns, would be cut again and again; one that is not wider is its own
// mean.
Piece piece_between_knots(Cubic value, real noise) {
  int k = transfer_interval(value.f_0);
  real4 head = knot_head(k);
  real4 next = knot_head(k + 1);
  bool before = value.f_0 < head.x;
  bool behind = value.f_0 > next.x;
  bool outside = before || behind;
  real width = next.x - head.x;
  bool narrow = width <= noise;
  real b = outside || narrow ? real(0.0) : (next.y - head.y) / width;
  real a = narrow ? real(0.5) * (head.y + next.y) : head.y - b * head.x;
  if (outside) a = before ? head.y : next.y;
  // all of the piece but its end by a knot, so that a GPU keeps few registers while that is searched
  Piece piece = Piece(first_turn(value, noise), a, b, before ? -1 : behind ? knots() - 1 : k);
  real far = real(3e38);
  real low = before ? -far : (behind ? next.x : head.x) - noise;
  real high = behind ? far : (before ? head.x : next.x) + noise;
  piece.part = min(first_exit(value, low, high), piece.part);
  return piece;
}

// The function's mean over values that are linear from front to back.
struct Average {
  real attenuation;
  real3 source;  // attenuation times colour
};

// Over the part [from, to] of interval k: linear attenuation times linear colour.
Average interval_mean(int k, real from, real to) {
  Classified a = classify_in(k, from);
  Classified b = classify_in(k, to);
  return Average(real(0.5) * (a.attenuation + b.attenuation),
                 (a.color * (real(2.0) * a.attenuation + b.attenuation)
                  + b.color * (a.attenuation + real(2.0) * b.attenuation)) / real(6.0));
}
Average interval_integral(int k, real from, real to) {
  Average mean = interval_mean(k, from, to);
  real part = (to - from) * range_unit();
  return Average(mean.attenuation * part, mean.source * part);
}

// By integral functions, kept from cancelling: whole intervals are the difference of two knots'
// integrals, the parts at both ends are summed by themselves.
Average transfer_average(real front, real back) {
  real lo = min(front, back);
  real hi = max(front, back);
  int i = transfer_interval(lo);
  int k = transfer_interval(hi);
  real first = knot_value(0);
  real last = knot_value(knots() - 1);
  // nearly equal values: of one interval's linear functions the mean of the ends
  if ((i == k && lo >= first && hi <= last) || hi <= lo) return interval_mean(i, lo, hi);
  // outside the knots the function is constant
  real below = max(min(hi, first) - lo, real(0.0)) * range_unit();
  real above = max(hi - max(lo, last), real(0.0)) * range_unit();
  real a = clamp(lo, first, last);
  real b = clamp(hi, first, last);
  Average sum = Average(real(0.0), real3(real(0.0)));
  if (i == k) {
    sum = interval_integral(i, a, b);
  } else {
    Average head = interval_integral(i, a, knot_value(i + 1));
    Average tail = interval_integral(k, knot_value(k), b);
    sum.attenuation = head.attenuation + tail.attenuation + (knot_integral(k) - knot_integral(i + 1));
    sum.source = head.source + tail.source + (knot_color_integral(k) - knot_color_integral(i + 1));
  }
  Classified c = classify_in(0, first);
  Classified d = classify_in(knots() - 2, last);
  real length = (hi - lo) * range_unit();
  sum.attenuation = (sum.attenuation + below * c.attenuation + above * d.attenuation) / length;
  sum.source = (sum.source + c.color * (below * c.attenuation)
                + d.color * (above * d.attenuation)) / length;
  return sum;
}

// The result of a rule that applies the function itself: the segment's optical depth and its mean
// luminance, C = L (1 - e^{-depth}).
struct Mixture {
  real depth;
  real3 L;
};
