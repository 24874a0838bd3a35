// The greatest value of a ray (mip), its first local maximum of at least a threshold (lmip), its least
// (minip), or their mean. The ray keeps the value in radiance.x, below 0 where the least is sought, and its
// place in shown_at; of the mean it keeps the integral in x. Of both the length met is in y, that of absent
// values in z.

// Looks at a value. LMIP ends where values fall behind a maximum that reaches the threshold. What
// rounding makes of a plateau, or of a value seen from both sides of a face, is no fall (least_value).
void see_value(INOUT(March) m, real of, real t) {
  real value = mode == MODE_minip && of > UNKNOWN ? -of : of;  // an absent one is UNKNOWN
  bool seen = !m.done && m.own;
  bool fallen = value < m.radiance.x - least_value;
  if (mode == MODE_lmip && seen && fallen && m.radiance.x >= lmip_threshold) {
    m.done = true;
  } else if (seen && value > m.radiance.x) {
    m.radiance.x = value;
    m.shown_at = t;
  }
}

// Counts a piece, and adds its mean.
void add_mean(INOUT(March) m, real mean, real length) {
  if (!m.own) return;
  m.radiance.y += length;
  if (!(mean > UNKNOWN)) m.radiance.z += length;
  else if (mode == MODE_mean) m.radiance.x += mean * length;
}

// A piece of a cell: its greatest value is at its ends or where its cubic turns.
void value_cell(INOUT(March) m, Cubic value, real t_back) {
  real length = t_back - m.t;
  if (sees_all) add_mean(m, value.f_0 > UNKNOWN ? antiderivative(value, real(1.0)) : UNKNOWN, length);
  if (mode != MODE_mean) {
    Turns turn = turning_points(value);
    see_value(m, value.f_0, m.t);
    see_value(m, polynomial(value, turn.first), m.t + turn.first * length);
    see_value(m, polynomial(value, turn.second), m.t + turn.second * length);
    see_value(m, polynomial(value, real(1.0)), t_back);
  }
  m.t = t_back;
  m.front.value = polynomial(value, real(1.0));
}

// A step, by the values at its ends.
void value_step(INOUT(March) m, real back, real t_back) {
  bool known = m.front.value > UNKNOWN && back > UNKNOWN;
  if (sees_all) add_mean(m, known ? real(0.5) * (m.front.value + back) : UNKNOWN, t_back - m.t);
  if (mode != MODE_mean) {
    see_value(m, m.front.value, m.t);
    see_value(m, back, t_back);
  }
  m.t = t_back;
  m.front.value = back;
}

// The value that a ray has met.
real value_of(IN(March) m) {
  if (mode == MODE_mean) return m.radiance.x / max(m.radiance.y - m.radiance.z, real(1e-37));
  return mode == MODE_minip ? -m.radiance.x : m.radiance.x;
}

// Whether the ray has met a value, and one that attenuates. What rounding makes of 0 is 0.
bool has_value(IN(March) m) {
  if (!((mode == MODE_mean ? m.radiance.y - m.radiance.z : m.radiance.x - UNKNOWN) > real(0.0))) return false;
  real value = abs(value_of(m)) < least_value ? real(0.0) : value_of(m);
  return (transfer ? classify(value).attenuation : value) > real(0.0);
}

real4 value_picture(IN(March) m) {
  if (!has_value(m)) return real4(real(0.0));
  real3 shown = real3(value_of(m));
  if (luminance_source == SOURCE_TRANSFER) shown = classify(value_of(m)).color;
  return real4(color * shown, real(1.0));
}

// The value, and 1 if LMIP ended there. Of all that a ray passes: a mean's absent length or what a least
// value has met, and the ray's length, as what no region meets is vacuum. The ray is the one marched: made
// again, its end might differ by rounding.
real4 value_collected(IN(March) m, Ray ray) {
  real length = mode == MODE_mean ? m.radiance.z : m.radiance.y;
  if (sees_all) return real4(m.radiance.x, length, max(ray.end - ray.begin, real(0.0)), real(0.0));
  bool found = mode == MODE_lmip && m.done && m.t < ray.end;
  return real4(m.radiance.x, real(found ? 1.0 : 0.0), real(0.0), real(0.0));
}
