// The greatest value of a ray (mip), or its first local maximum of at least a threshold (lmip). The
// ray keeps the value in radiance.x and its place in half_depth.

// Looks at a value. LMIP ends where values fall behind a maximum that reaches the threshold. What
// rounding makes of a plateau, or of a value seen from both sides of a face, is no fall (least_value).
void see_value(INOUT(March) m, real value, real t) {
  bool seen = !m.done && m.own;
  bool fallen = value < m.radiance.x - least_value;
  if (mode == MODE_lmip && seen && fallen && m.radiance.x >= lmip_threshold) {
    m.done = true;
  } else if (seen && value > m.radiance.x) {
    m.radiance.x = value;
    m.half_depth = t;
  }
}

// The greatest value of a piece of a cell: at its ends or where its cubic turns.
void value_cell(INOUT(March) m, Cubic value, real t_back) {
  real length = t_back - m.t;
  Turns turn = turning_points(value);
  see_value(m, value.f_0, m.t);
  see_value(m, polynomial(value, turn.first), m.t + turn.first * length);
  see_value(m, polynomial(value, turn.second), m.t + turn.second * length);
  see_value(m, polynomial(value, real(1.0)), t_back);
  m.t = t_back;
  m.front.value = polynomial(value, real(1.0));
}

// The greater value of a step's ends.
void value_step(INOUT(March) m, real back, real t_back) {
  see_value(m, m.front.value, m.t);
  see_value(m, back, t_back);
  m.t = t_back;
  m.front.value = back;
}

// Whether the ray has met a value, and one that attenuates. What rounding makes of 0 is 0.
bool has_value(IN(March) m) {
  if (!(m.radiance.x > UNKNOWN)) return false;
  real value = abs(m.radiance.x) < least_value ? real(0.0) : m.radiance.x;
  return (transfer ? classify(value).attenuation : value) > real(0.0);
}

real4 value_picture(IN(March) m) {
  if (!has_value(m)) return real4(real(0.0));
  real3 shown = real3(m.radiance.x);
  if (luminance_source == SOURCE_TRANSFER) shown = classify(m.radiance.x).color;
  return real4(color * shown, real(1.0));
}

// The value, and 1 if LMIP ended there. The ray is the one marched: made again, its end might differ
// by rounding.
real4 value_collected(IN(March) m, Ray ray) {
  bool found = mode == MODE_lmip && m.done && m.t < ray.end;
  return real4(m.radiance.x, real(found ? 1.0 : 0.0), real(0.0), real(0.0));
}
