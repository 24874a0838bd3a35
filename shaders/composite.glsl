// Adds a term to a sum, compensated (Kahan): 1e5 thin steps keep it. `lost`: what rounding left out.
// `precise`: algebra would make it 0, and a fused term would not be what was added.
void add_to(INOUT(real) total, INOUT(real) lost, real term) {
  precise real y = term - lost;
  precise real sum = total + y;
  precise real left = (sum - total) - y;
  total = sum;
  lost = left;
}

// Adds light to the ray's sum; of a vector three.
void add_light(INOUT(March) m, real3 C) {
  add_to(m.radiance.x, m.radiance_lost.x, C.x);
  if (!vector_radiance) return;
  add_to(m.radiance.y, m.radiance_lost.y, C.y);
  add_to(m.radiance.z, m.radiance_lost.z, C.z);
}

// Keeps where the transmittance falls below 1/2, if it does on the `length` from m.t on, which has
// the optical depth `depth` and an attenuation proportional to `tau`.
void find_half(INOUT(March) m, Cubic tau, real depth, real length) {
  if (!find_depth) return;
  if (m.shown_at >= NEVER && m.optical_depth + depth > m.half_at) {
    // an end correction may have passed it
    real s = m.optical_depth < m.half_at ? (m.half_at - m.optical_depth) / depth : real(0.0);
    real target = s * antiderivative(tau, real(1.0));
    real low = real(0.0);
    real high = real(1.0);
    for (int i = 0; i < 12; ++i) {  // Newton's steps, and halves where they leave the interval
      real off = antiderivative(tau, s) - target;
      if (off < real(0.0)) low = s;
      else high = s;
      s = s - off / polynomial(tau, s);
      if (!(s >= low && s <= high)) s = real(0.5) * (low + high);
    }
    m.shown_at = m.t + length * s;
  }
}

// Adds optical depth, and ends the ray behind which nothing is seen.
void deepen(INOUT(March) m, real depth) {
  add_to(m.optical_depth, m.lost, depth);
  if (ends_early && m.optical_depth > m.stop_at) m.done = true;
}

// Composites what starts at m.t: I += T C, T *= zeta = 1 - opacity; back to front I = C + zeta I.
// `glow`: what it emits by itself, as seen at its front.
void composite(INOUT(March) m, real3 C, real opacity, real depth, real3 glow, real length) {
  if (count_steps && depth > real(0.0)) m.steps += 1;
  if (vector_radiance) {
    if (adds_glow) C = C * (color * m.phase) + glow;
    if (from_back) m.radiance = C + m.radiance * (real(1.0) - opacity);
    else add_light(m, C * m.transmittance);
  } else if (!constant_luminance) {
    if (from_back) m.radiance.x = C.x + m.radiance.x * (real(1.0) - opacity);
    else add_light(m, real3(C.x * m.transmittance, real(0.0), real(0.0)));
  }
  m.transmittance -= m.transmittance * opacity;
  deepen(m, depth);
  m.t += length;
}

// Where a run of equal steps begins or ends, psi-balanced is of second order unless corrected: with
// k = h^2/12 of the segment before t and of the one from t on, and kappa their difference,
//   e = exp(kappa tau'),  I += T (L (1 - e) - kappa L' tau),  T *= e      (docs/method.md)
// `kappa` [(unit of t)^2]; `x`: optical depth of the segment whose correction it is. Where a step is
// opaque the expansion says nothing, and its terms fade out as 1/(1 + x^2); no linear attenuation
// has one of more than a sixth of x, and none may be more than a quarter.
void correct_step(INOUT(March) m, real kappa, real x) {
  real fade = kappa / (real(1.0) + x * x);
  real y = clamp(-fade * extinction * m.front.slope, real(-0.25) * x, real(0.25) * x);
  Decay d = decay(abs(y));
  real opacity = y < real(0.0) ? -d.a / d.e : d.a;
  real3 C = m.front.L * opacity
          - m.front.L_slope * (fade * extinction * m.front.attenuation);
  if (!constant_luminance || vector_radiance) add_light(m, C * m.transmittance);
  m.transmittance -= m.transmittance * opacity;
  deepen(m, y);
}

// The light that a segment emits and that leaves it at its front, for its luminance's weights.
real3 glow_of_segment(Point near, Point middle, Point back, Weights w, real length) {
  Weights e = Weights(real(1.0 / 6.0), real(4.0 / 6.0), real(1.0 / 6.0), real(0.0));
  if (middle_rule) {  // a homogeneous step, as of the luminance
    real opacity = w.front + w.middle + w.back;
    real seen = w.depth > real(0.0) ? opacity / w.depth : real(1.0);
    e = Weights(real(0.0), seen, real(0.0), w.depth);
  } else if (attenuates) e = glow_weights(w.depth);
  return (near.glow * e.front + middle.glow * e.middle + back.glow * e.back) * length;
}

// The attenuation that a segment is taken to have, from its front at 0 to its back at 1.
Cubic attenuation_along(Point front, Point middle, Point back) {
  if (middle_rule) return Cubic(middle.attenuation, real(0.0), real(0.0), real(0.0));
  if (uniform_sampling)
    return Cubic(front.attenuation, back.attenuation - front.attenuation, real(0.0), real(0.0));
  return make_cubic(front.attenuation, middle.attenuation, back.attenuation, real(0.0));
}

// One segment from m.t to t_back, of linear or sampled values; leaves the front of the next one.
// Under cells its optical depth is Simpson's, which is exact for a cubic attenuation; under uniform
// it is the depth of a linear one.
// `constant_run`: it is exact.
void composite_segment(INOUT(March) m, Sample sample_middle, Sample sample_back, real t_back, real length,
                       bool constant_run) {
  real t_middle = t_back - real(0.5) * length;
  Point front = m.front;
  Point middle = m.front;
  real3 none = real3(real(0.0));
  Point back = Point(sample_back.value, real(0.0), none, none, none, real(0.0), none);
  if (middle_rule || has_emission) {
    seek(m, t_middle, middle_rule);
    middle = point_at(m, t_middle, sample_middle, middle_rule);
  } else if (!uniform_sampling) {
    middle.attenuation =
        vacuum_differs && m.vacuum ? real(0.0) : attenuation_of(m, sample_middle);
  }
  if (!middle_rule) {
    seek(m, t_back, true);
    back = point_at(m, t_back, sample_back, true);
  }
  if (beside_density) {
    if (!m.paired_front) m.front.L = back.L;
    front.L = m.front.L;
    m.paired_front = m.paired_here;
  }
  real mean = uniform_sampling
                  ? real(0.5) * (front.attenuation + back.attenuation)
                  : (front.attenuation + real(4.0) * middle.attenuation + back.attenuation)
                        / real(6.0);
  real depth = max(extinction * length * mean, real(0.0));
  if (end_corrections && length > real(0.0)) {
    real step_error = constant_run ? real(0.0) : length * length / real(12.0);
    if (m.own) correct_step(m, m.step_error - step_error, depth);
    m.step_error = step_error;
  }
  m.front = back;
  Cubic tau = attenuation_along(front, middle, back);
  Point near = front;
  if (from_back) {
    near = back;
    back = front;
  }
  Weights w = Weights(real(0.0), real(0.0), real(0.0), depth);
  if (transfer_rule) {
    Mixture mixture = integrate_transfer(near.value, back.value, m.vacuum ? real(0.0) : length);
    real a = decay(mixture.depth).a;
    bool own = function_colors;  // else the luminance is the mean of the ends
    w = Weights(own ? real(0.0) : real(0.5) * a, own ? a : real(0.0), own ? real(0.0) : real(0.5) * a,
                mixture.depth);
    middle.L = mixture.L;
    if (lit_colors) middle.L = (near.L + back.L) * real(0.5);
    middle.tint = mixture.L;
  } else if (!depth_only && attenuates) {
    w = integrate_segment(Segment(extinction * near.attenuation, extinction * middle.attenuation,
                                  extinction * back.attenuation, length, depth));
  }
  if (!m.own) w = Weights(real(0.0), real(0.0), real(0.0), real(0.0));
  real3 glow = real3(real(0.0));
  if (glows(m)) glow = glow_of_segment(near, middle, back, w, length);
  find_half(m, tau, w.depth, length);
  real3 C = luminance_of(near) * w.front + luminance_of(middle) * w.middle + luminance_of(back) * w.back;
  composite(m, C, w.front + w.middle + w.back, w.depth, glow, length);
  m.t = t_back;
}

// A cell from m.t to t_back whose optical depth is all that counts.
void composite_depth(INOUT(March) m, Cubic attenuation, real t_back, real length) {
  real depth = max(extinction * length * antiderivative(attenuation, real(1.0)), real(0.0));
  if (count_steps && depth > real(0.0)) m.steps += 1;
  find_half(m, attenuation, depth, length);
  deepen(m, depth);
  m.t = t_back;
}

// What a piece of a cell holds: cubics from its front to its back.
struct CellPiece {
  real unit;    // depth where tau / extinction is 1, an eighth of it in a deep cell
  Cubic value;  // of the density grid
  Cubic tau;    // tau / extinction, from the camera's end on
  Cubics L;     // of a luminance grid
  EmissionPiece glow;
};

// The luminance grid along the piece, in whose middle its node was sought.
Cubics luminance_along(IN(March) m, real length) {
  int channels = luminance_source == SOURCE_VECTOR ? 3 : 1;
  Cubics L = constant_cubics(m.front.L);
  if (beside_density && !hardware_filter && m.paired_here)
    L = cubics_along(m.pairs, channels, position(m.luminance.ray, m.t) - m.pairs_at,
                     m.luminance.ray.direction * length);
  else if (!beside_density || m.paired_here)
    L = track_cubics(luminance_grid, channels, m.luminance, m.t, length);
  return L;
}

// What the nodes of a piece add up to.
struct NodeSum {
  real weight;
  real value;  // of the density grid, times its weight
  real3 L;     // of a luminance grid, times its weight
  real3 lit;   // lit_colors: the value times that
  real3 glow;  // as seen at the piece's front
  real own;      // part of the weight that is the density's; the rest is the further volumes'
  real3 others;  // their luminance, times their weight
};

// Sums of weights times great values need a unit; the mean divides it out again.
real weight_unit() { return great_values ? node_unit : real(1.0); }

// The node at `place` of the way through the piece: `share` is its part of the piece.
void add_node(INOUT(NodeSum) sum, IN(March) m, IN(CellPiece) piece, real place, real share) {
  real s = from_back ? real(1.0) - place : place;
  real depth = piece.unit * antiderivative(piece.tau, s);
  real through = share * (cell_nodes == 4 ? shallow_decay(depth) : deep_decay(depth));
  real weight = integrate_cell(piece.tau, through, s) * weight_unit();
  sum.weight += weight;
  if (other_volumes > 0) {
    if (others_shine) sum.others = sum.others + source_at(m.others, place) * (through * weight_unit());
    if (others_shine) sum.glow = sum.glow + polynomials(m.others.glow, place) * through;
    weight = integrate_cell(piece.value, through, place) * weight_unit();
    sum.own += weight;
  }
  real value = polynomial(piece.value, place);
  sum.value += value * weight;
  if (own_luminance) {
    real3 L = real3(polynomial(piece.L.x, place));
    if (luminance_source == SOURCE_VECTOR) L = polynomials(piece.L, place);
    sum.L = sum.L + L * weight;
    if (lit_colors) sum.lit = sum.lit + L * (value * weight);
  }
  if (glows(m)) sum.glow = sum.glow + emission_of(piece.glow, place, through);
}

// The mean value that one channel of the light shows; where there is none any will do.
real lit_value(real lit, real L, real value) { return abs(L) > real(1e-37) ? lit / L : value; }

// The colour of a piece by what its nodes add up to; `value`: their mean.
real3 tint_of(IN(March) m, IN(NodeSum) sum, real value) {
  return colors_within(m.interval, real3(lit_value(sum.lit.x, sum.L.x, value),
                                         lit_value(sum.lit.y, sum.L.y, value),
                                         lit_value(sum.lit.z, sum.L.z, value)));
}

// A piece of a cell from m.t to t_back by a rule that integrates its cubic in Gauss-Legendre nodes;
// `attenuation` is the cubic of tau / extinction, `value` that of the density grid.
void composite_cell(INOUT(March) m, Cubic value, Cubic attenuation, real t_back, real length) {
  real3 none = real3(real(0.0));
  CellPiece piece = CellPiece(extinction * length * (cell_nodes == 4 ? real(1.0) : real(0.125)), value,
                              attenuation, constant_cubics(none), no_emission());
  if (from_back) piece.tau = reversed(attenuation);
  seek(m, m.t + real(0.5) * length, true);
  if (own_luminance) piece.L = luminance_along(m, length);
  if (has_emission) piece.glow = emission_along(m.emission, m.t, length);
  NodeSum sum = NodeSum(real(0.0), real(0.0), none, none, none, real(0.0), none);
  if (cell_nodes == 4) {
    add_node(sum, m, piece, real(0.0694318442029737), real(0.1739274225687269));
    add_node(sum, m, piece, real(0.3300094782075719), real(0.3260725774312732));
    add_node(sum, m, piece, real(0.6699905217924281), real(0.3260725774312732));
    add_node(sum, m, piece, real(0.9305681557970262), real(0.1739274225687269));
  } else if (cell_nodes == 6) {
    add_node(sum, m, piece, real(0.0337652428984240), real(0.0856622461895852));
    add_node(sum, m, piece, real(0.1693953067668677), real(0.1803807865240693));
    add_node(sum, m, piece, real(0.3806904069584015), real(0.2339569672863456));
    add_node(sum, m, piece, real(0.6193095930415985), real(0.2339569672863456));
    add_node(sum, m, piece, real(0.8306046932331324), real(0.1803807865240693));
    add_node(sum, m, piece, real(0.9662347571015760), real(0.0856622461895852));
  } else {
    add_node(sum, m, piece, real(0.0198550717512319), real(0.0506142681451884));
    add_node(sum, m, piece, real(0.1016667612931866), real(0.1111905172266872));
    add_node(sum, m, piece, real(0.2372337950418355), real(0.1568533229389437));
    add_node(sum, m, piece, real(0.4082826787521751), real(0.1813418916891810));
    add_node(sum, m, piece, real(0.5917173212478248), real(0.1813418916891810));
    add_node(sum, m, piece, real(0.7627662049581645), real(0.1568533229389437));
    add_node(sum, m, piece, real(0.8983332387068135), real(0.1111905172266872));
    add_node(sum, m, piece, real(0.9801449282487682), real(0.0506142681451884));
  }
  real depth = max(extinction * length * antiderivative(attenuation, real(1.0)), real(0.0));
  real opacity = decay(depth).a;
  // between knots the luminance is linear in the value, so the mean value has the mean luminance; in
  // light it is the mean by light
  real scale = real(1.0) / max(other_volumes > 0 ? sum.own : sum.weight, real(1e-37));
  Point mean = Point(real(0.0), real(0.0), real3(real(1.0)), none, none, real(0.0), none);
  if (own_luminance) mean.L = sum.L * scale;
  if (lit_colors) mean.tint = tint_of(m, sum, sum.value * scale);
  else mean = with_value(m, mean, Sample(sum.value * scale, real(0.0)));
  real3 L = luminance_of(mean);
  real3 C = L * opacity;
  real3 glow = sum.glow * length;
  if (other_volumes > 0) {
    real share = opacity / max(sum.weight, real(1e-37));
    C = L * (share * sum.own);
    glow = glow + sum.others * share;
  }
  find_half(m, attenuation, depth, length);
  composite(m, C, opacity, depth, glow, length);
  m.t = t_back;
  m.front.value = polynomial(value, real(1.0));
}
