// The march: what a ray carries, and how a segment, a cell or a maximum is added to it. The loops over
// them are march_cells.glsl and march_uniform.glsl: both flat, from run to run of the page table and
// from segment to segment inside one.
//
// A turn of a loop holds one look-up, one leave() and one set of samples and weights, and what is
// rare (the first value of a ray, constant runs, empty ones) takes the same path with other
// numbers: llvmpipe executes both sides of every branch, so a rare branch costs as much as a
// frequent one.
const int MODE_ALPHA = 0;  // Mode
const int MODE_BACK_TO_FRONT = 1;
const int MODE_MIP = 2;
const int MODE_LMIP = 3;
const int MODE_ISOSURFACE = 4;
const int MODE_XRAY = 5;

const real NEVER = real(1e30);
const real UNKNOWN = real(-1e38);
const real LN2 = real(0.6931471805599453);

// The medium at a point of the ray.
struct Point {
  real value;        // of the density grid
  real attenuation;  // of it, without `extinction`
  real3 L;           // luminance, without `color`; only x where it is scalar
  real3 glow;        // emission [radiance / unit of t]
  real slope;        // of the attenuation along the ray [1 / unit of t]; these two only with
  real3 L_slope;     // end_corrections
};

// All that a ray carries from turn to turn, and from pass to pass.
struct March {
  real t;              // how far the ray is integrated
  Point front;         // the medium at t
  int3 cell;           // the next cell to look up in the density grid
  int lattice;         // template: the voxel that t is at
  bool known;          // `front` is that of t; if not, a turn of length 0 finds it
  bool vacuum;         // what the turn looks at is an empty run
  int interval;        // of the transfer function, where pieces end at its knots
  real phase;          // factor of all luminance along the ray
  real3 radiance;      // without `color`, unless there is emission; of maxima x is the value
  real optical_depth;
  real lost;           // what rounding left out of optical_depth (Kahan)
  real transmittance;  // e^{-optical_depth}; kept only where the radiance needs it
  real half_depth;     // t at which the transmittance falls below 1/2, or of the maximum, the surface
  real step_error;     // h^2/12 of the segment before t, see correct_step
  int steps;
  int samples;
  int turns;
  bool done;
  Ray luminance_ray;   // of a separate luminance grid, and the node that was read last
  Node luminance_node;
  Ray emission_ray;    // the same of an emission grid
  Node emission_node;
  Node gradient_node;  // the same of the gradient's, whose ray is the density's
};

#include "march_derived.glsl"

// Runs of one value that need no samples, where all else is constant along them too; and empty ones.
bool constant_run(Node node) {
  return constant_runs && node.kind == NODE_CONSTANT && !with_gradient && !own_luminance
         && !has_emission;
}
bool closed_form(Node node) { return node.kind == NODE_EMPTY || constant_run(node); }

// Where the walk goes on for the sake of another grid: no medium, whatever 0 means.
bool beyond_density(int3 cell) {
  return beyond && !inside(Node(0, 0, density_field_min, density_field_max), cell);
}

real node_value(Node node) {
  return constant_runs && node.kind == NODE_CONSTANT ? fetch_constant(GRID_DENSITY, node.payload)
                                                     : real(0.0);
}

// Node of another grid's that covers a cell.
Node seek_cell(int grid, int3 cell, Node node, int3 domain_min, int3 domain_max) {
  if (inside(node, cell)) return node;
  if (inside(Node(0, 0, domain_min, domain_max), cell)) return find_node(grid, cell);
  return Node(NODE_EMPTY, 1, cell, cell + 1);
}

// The same at t.
Node seek_node(int grid, Ray ray, Node node, int3 domain_min, int3 domain_max, real t) {
  return seek_cell(grid, int3(floor(position(ray, t))), node, domain_min, domain_max);
}

// Moves the gradient's node to a cell of the density's.
void seek_gradient(INOUT(March) m, int3 cell) {
  if (!with_gradient) return;
  m.gradient_node = seek_cell(GRID_GRADIENT, cell, m.gradient_node, density_field_min,
                              density_field_max);
  if (count_steps && m.gradient_node.kind == NODE_BRICK) m.samples += 1;
}

// Moves the nodes of separate grids to t; point_at(t) follows.
void seek(INOUT(March) m, real t) {
  if (own_luminance) {
    m.luminance_node = seek_node(GRID_LUMINANCE, m.luminance_ray, m.luminance_node,
                                 luminance_domain_min, luminance_domain_max, t);
    if (count_steps && m.luminance_node.kind == NODE_BRICK) m.samples += 1;
  }
  if (has_emission) {
    m.emission_node = seek_node(GRID_EMISSION, m.emission_ray, m.emission_node,
                                emission_domain_min, emission_domain_max, t);
    if (count_steps && m.emission_node.kind == NODE_BRICK) m.samples += 1;
  }
}

real3 sample_grid(int grid, int channels, Node node, Ray ray, real t) {
  if (node.kind == NODE_EMPTY) return real3(real(0.0));
  if (channels == 3) return sample_vector(grid, node, position(ray, t));
  real v = sample_scalar(grid, node, position(ray, t));
  return real3(v, v, v);
}

Classified classify_at(IN(March) m, Sample s) {
  if (keeps_interval) return classify_within(m.interval, s.value);
  return classify(s);
}

real attenuation_of(IN(March) m, Sample s) {
  return transfer ? classify_at(m, s).attenuation : s.value;
}

// The same point with another value of the density grid.
Point with_value(IN(March) m, Point p, Sample s) {
  real value = s.value;
  Classified c = Classified(value, real3(real(1.0)));
  if (transfer) c = classify_at(m, s);
  p.value = value;
  p.attenuation = m.vacuum ? real(0.0) : c.attenuation;
  if (luminance_source == SOURCE_DENSITY) p.L = real3(value, value, value);
  if (luminance_source == SOURCE_TRANSFER) p.L = c.color;
  return p;
}

// The medium at t, where the density grid has `s`; other grids' nodes are there already.
Point point_at(IN(March) m, real t, Sample s) {
  real3 none = real3(real(0.0));
  Point p = Point(s.value, s.value, real3(real(1.0)), none, real(0.0), none);
  if (own_luminance)
    p.L = sample_grid(GRID_LUMINANCE, luminance_source == SOURCE_VECTOR ? 3 : 1, m.luminance_node,
                      m.luminance_ray, t);
  if (has_emission)
    p.glow = sample_grid(GRID_EMISSION, emission_channels, m.emission_node, m.emission_ray, t)
           * emission_scale;
  return with_value(m, p, s);
}

// Adds optical depth, compensated: 1e5 thin steps keep their sum.
void deepen(INOUT(March) m, real depth, real length) {
  if (find_depth && m.half_depth >= NEVER && m.optical_depth + depth > LN2)
    m.half_depth = m.t + length * ((LN2 - m.optical_depth) / depth);
  precise real y = depth - m.lost;
  precise real sum = m.optical_depth + y;
  precise real lost = (sum - m.optical_depth) - y;
  m.optical_depth = sum;
  m.lost = lost;
  if (ends_early && sum > stop_depth) m.done = true;
}

// Loops are of so many turns, inside a loop that takes the transmittance from the optical depth itself:
// between, the product of T picks up as many roundings, and a long ray has no floor that grows with its
// steps.
const int turns_of_product = 16;

void refresh_transmittance(INOUT(March) m) {
  if (!depth_only) m.transmittance = decay(m.optical_depth).e;
}

void end_turn(INOUT(March) m, Ray ray) {
  m.turns += 1;
  if (m.t >= ray.end) m.done = true;
}

// Composites a segment that starts at m.t: I += T C, T *= zeta = 1 - the sum of the weights; back to
// front I = C + zeta I. `glow`: what the segment emits by itself, as seen at its front.
void composite(INOUT(March) m, Weights w, real3 L_front, real3 L_middle, real3 L_back, real3 glow,
               real length) {
  if (count_steps && w.depth > real(0.0)) m.steps += 1;
  real opacity = w.front + w.middle + w.back;
  real before = mode == MODE_BACK_TO_FRONT ? real(1.0) - opacity : real(1.0);
  real through = mode == MODE_BACK_TO_FRONT ? real(1.0) : m.transmittance;
  if (vector_radiance) {
    real3 C = L_front * w.front + L_middle * w.middle + L_back * w.back;
    if (has_emission) C = C * (color * m.phase) + glow;
    m.radiance = m.radiance * before + C * through;
  } else if (!constant_luminance) {
    real C = L_front.x * w.front + L_middle.x * w.middle + L_back.x * w.back;
    m.radiance.x = m.radiance.x * before + C * through;
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
  if (vector_radiance) m.radiance = m.radiance + C * m.transmittance;
  else if (!constant_luminance) m.radiance.x += C.x * m.transmittance;
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
    seek(m, t_middle);
    middle = point_at(m, t_middle, sample_middle);
  } else if (!uniform_sampling) {
    middle.attenuation = m.vacuum ? real(0.0) : attenuation_of(m, sample_middle);
  }
  if (!middle_rule || has_emission) {
    seek(m, t_back);
    back = point_at(m, t_back, sample_back);
  }
  real mean = uniform_sampling
                  ? real(0.5) * (front.attenuation + back.attenuation)
                  : (front.attenuation + real(4.0) * middle.attenuation + back.attenuation)
                        / real(6.0);
  real depth = max(extinction * length * mean, real(0.0));
  if (end_corrections && length > real(0.0)) {
    real step_error = constant_run ? real(0.0) : length * length / real(12.0);
    correct_step(m, m.step_error - step_error, depth);
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
  real3 glow = real3(real(0.0));
  if (has_emission) {
    Weights e = Weights(real(1.0 / 6.0), real(4.0 / 6.0), real(1.0 / 6.0), real(0.0));
    if (attenuates) e = glow_weights(w.depth);
    glow = (near.glow * e.front + middle.glow * e.middle + back.glow * e.back) * length;
  }
  composite(m, w, near.L, middle.L, back.L, glow, length);
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
  seek(m, t_1);
  Point p_1 = point_at(m, t_1, Sample(polynomial(value, s_1), real(0.0)));
  seek(m, t_2);
  Point p_2 = point_at(m, t_2, Sample(polynomial(value, real(0.5)), real(0.0)));
  seek(m, t_3);
  Point p_3 = point_at(m, t_3, Sample(polynomial(value, s_3), real(0.0)));
  Cubic tau = attenuation;
  if (reversed_ray) tau = reversed(attenuation);
  real x = extinction * length;
  Weights w = integrate_cell(tau, x);
  real3 glow = real3(real(0.0));
  if (has_emission)
    glow = (p_1.glow * (real(5.0) * decay(x * antiderivative(tau, cell_node_1)).e)
            + p_2.glow * (real(8.0) * decay(x * antiderivative(tau, real(0.5))).e)
            + p_3.glow * (real(5.0) * decay(x * antiderivative(tau, cell_node_3)).e))
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
  if (m.done) return;
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
