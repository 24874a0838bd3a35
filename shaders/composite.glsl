// Adds a term to a sum, compensated (Kahan): 1e5 thin steps keep it. `lost`: what rounding left out.
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

// Adds optical depth, and ends the ray behind which nothing is seen.
void deepen(INOUT(March) m, real depth, real length) {
  if (find_depth && m.half_depth >= NEVER && m.optical_depth + depth > LN2)
    m.half_depth = m.t + length * ((LN2 - m.optical_depth) / depth);
  add_to(m.optical_depth, m.lost, depth);
  if (ends_early && m.optical_depth > stop_depth) m.done = true;
}

// Composites a segment that starts at m.t: I += T C, T *= zeta = 1 - the sum of the weights; back to
// front I = C + zeta I. `glow`: what the segment emits by itself, as seen at its front.
void composite(INOUT(March) m, Weights w, real3 L_front, real3 L_middle, real3 L_back, real3 glow,
               real length) {
  if (count_steps && w.depth > real(0.0)) m.steps += 1;
  real opacity = w.front + w.middle + w.back;
  bool back_to_front = mode == MODE_BACK_TO_FRONT;
  if (vector_radiance) {
    real3 C = L_front * w.front + L_middle * w.middle + L_back * w.back;
    if (has_emission) C = C * (color * m.phase) + glow;
    if (back_to_front) m.radiance = C + m.radiance * (real(1.0) - opacity);
    else add_light(m, C * m.transmittance);
  } else if (!constant_luminance) {
    real C = L_front.x * w.front + L_middle.x * w.middle + L_back.x * w.back;
    if (back_to_front) m.radiance.x = C + m.radiance.x * (real(1.0) - opacity);
    else add_light(m, real3(C * m.transmittance, real(0.0), real(0.0)));
  }
  m.transmittance -= m.transmittance * opacity;
  deepen(m, w.depth, length);
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
  deepen(m, y, real(0.0));
}

// One segment from m.t to t_back, of linear or sampled values; leaves the front of the next one.
// Under cells its optical depth is Simpson's, which is exact for a cubic attenuation; under uniform
// it is that of a linear one.
// `constant_run`: it is exact.
void composite_segment(INOUT(March) m, Sample sample_middle, Sample sample_back, real t_back, real length,
                       bool constant_run) {
  real t_middle = t_back - real(0.5) * length;
  Point front = m.front;
  Point middle = m.front;
  real3 none = real3(real(0.0));
  Point back = Point(sample_back.value, real(0.0), none, none, real(0.0), none);
  if (middle_rule || has_emission) {
    seek(m, t_middle, middle_rule);
    middle = point_at(m, t_middle, sample_middle, middle_rule);
  } else if (!uniform_sampling) {
    middle.attenuation =
        vacuum_differs && m.vacuum ? real(0.0) : attenuation_of(m, sample_middle);
  }
  if (!middle_rule || has_emission) {
    seek(m, t_back, !middle_rule);
    back = point_at(m, t_back, sample_back, !middle_rule);
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
  Point near = front;
  if (mode == MODE_BACK_TO_FRONT) {
    near = back;
    back = front;
  }
  Weights w = Weights(real(0.0), real(0.0), real(0.0), depth);
  if (transfer_rule) {
    Mixture mixture = integrate_transfer(near.value, back.value, m.vacuum ? real(0.0) : length);
    real a = decay(mixture.depth).a;
    bool own = luminance_source == SOURCE_TRANSFER;  // else the luminance is the mean of the ends
    w = Weights(own ? real(0.0) : real(0.5) * a, own ? a : real(0.0), own ? real(0.0) : real(0.5) * a,
                mixture.depth);
    middle.L = mixture.L;
  } else if (!depth_only && attenuates) {
    w = integrate_segment(Segment(extinction * near.attenuation, extinction * middle.attenuation,
                                  extinction * back.attenuation, length, depth));
  }
  if (!m.own) w = Weights(real(0.0), real(0.0), real(0.0), real(0.0));
  real3 glow = real3(real(0.0));
  if (glows(m)) {
    Weights e = Weights(real(1.0 / 6.0), real(4.0 / 6.0), real(1.0 / 6.0), real(0.0));
    if (attenuates) e = glow_weights(w.depth);
    glow = (near.glow * e.front + middle.glow * e.middle + back.glow * e.back) * length;
  }
  composite(m, w, near.L, middle.L, back.L, glow, length);
  m.t = t_back;
}

// A cell from m.t to t_back whose optical depth is all that counts.
void composite_depth(INOUT(March) m, Cubic attenuation, real t_back, real length) {
  real depth = max(extinction * length * antiderivative(attenuation, real(1.0)), real(0.0));
  if (count_steps && depth > real(0.0)) m.steps += 1;
  deepen(m, depth, length);
  m.t = t_back;
}

// A piece of a cell from m.t to t_back by a rule that integrates its cubic from three nodes;
// `attenuation` is the cubic of tau / extinction, `value` that of the density grid.
void composite_cell(INOUT(March) m, Cubic value, Cubic attenuation, real t_back, real length) {
  bool reversed_ray = mode == MODE_BACK_TO_FRONT;
  real s_1 = reversed_ray ? cell_node_3 : cell_node_1;  // the first node is the camera's
  real s_3 = reversed_ray ? cell_node_1 : cell_node_3;
  real t_1 = m.t + s_1 * length;
  real t_2 = m.t + real(0.5) * length;
  real t_3 = m.t + s_3 * length;
  seek(m, t_1, true);
  Point p_1 = point_at(m, t_1, Sample(polynomial(value, s_1), real(0.0)), true);
  seek(m, t_2, true);
  Point p_2 = point_at(m, t_2, Sample(polynomial(value, real(0.5)), real(0.0)), true);
  seek(m, t_3, true);
  Point p_3 = point_at(m, t_3, Sample(polynomial(value, s_3), real(0.0)), true);
  Cubic tau = attenuation;
  if (reversed_ray) tau = reversed(attenuation);
  real x = extinction * length;
  Weights w = integrate_cell(tau, x);
  real3 glow = real3(real(0.0));
  if (glows(m))
    glow = (p_1.glow * (real(5.0) * shallow_decay(x * antiderivative(tau, cell_node_1)))
            + p_2.glow * (real(8.0) * shallow_decay(x * antiderivative(tau, real(0.5))))
            + p_3.glow * (real(5.0) * shallow_decay(x * antiderivative(tau, cell_node_3))))
           * (length / real(18.0));
  composite(m, w, p_1.L, p_2.L, p_3.L, glow, length);
  m.t = t_back;
  m.front.value = polynomial(value, real(1.0));
}

// A value on the way to a maximum. LMIP ends behind the first one that is at least the threshold;
// what rounding makes of a plateau, or of a value seen from both sides of a face, is no fall.
#if REAL_BITS == 64
const real least_fall = real(1e-12);
#else
const real least_fall = real(4e-6);
#endif
void see_value(INOUT(March) m, real value, real t) {
  if (m.done || !m.own) return;
  real fallen = m.radiance.x - least_fall * abs(m.radiance.x);
  if (mode == MODE_LMIP && value < fallen && m.radiance.x >= lmip_threshold) m.done = true;
  else if (value > m.radiance.x) {
    m.radiance.x = value;
    m.half_depth = t;
  }
}

// The greatest value of a piece of a cell: at its ends or where its cubic turns.
void see_cell(INOUT(March) m, Cubic value, real t_back) {
  real length = t_back - m.t;
  Turns turn = turning_points(value);
  see_value(m, value.f_0, m.t);
  see_value(m, polynomial(value, turn.first), m.t + turn.first * length);
  see_value(m, polynomial(value, turn.second), m.t + turn.second * length);
  see_value(m, polynomial(value, real(1.0)), t_back);
  m.t = t_back;
  m.front.value = polynomial(value, real(1.0));
}
