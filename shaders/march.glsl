// The march: along one ray, front to back, from run to run of the page table and from segment to
// segment inside one. Both samplings are one flat loop each over the same parts.
//
// A turn of a loop holds one look-up, one leave() and one set of samples and weights, and what is
// rare (the first value of a ray, constant runs, empty ones) takes the same path with other
// numbers: llvmpipe executes both sides of every branch, so a rare branch costs as much as a
// frequent one.

// All that a ray carries from turn to turn, and from pass to pass.
struct March {
  real t;              // how far the ray is integrated
  real value;          // of the density grid at t; negative: not known
  int3 cell;           // the next cell to look up in the density grid
  int lattice;         // uniform: t lies in [lattice, lattice + 1) * step
  bool known;          // value and L are those at t; if not, a turn of length 0 finds them
  real3 L;             // luminance at t, without `color`
  real3 radiance;      // without `color`; only x where the luminance is scalar
  real optical_depth;
  real lost;           // what rounding left out of optical_depth (Kahan)
  real transmittance;  // e^{-optical_depth}; kept only where the radiance needs it
  real half_depth;     // t at which the transmittance falls below 1/2
  int steps;
  int samples;
  int turns;
  bool done;
  Ray luminance_ray;   // of a separate luminance grid, and the node that was read last
  Node luminance_node;
};

const real NEVER = real(1e30);
const real LN2 = real(0.6931471805599453);

bool constant_luminance() { return luminance_source == SOURCE_CONSTANT; }
bool own_luminance() {
  return luminance_source == SOURCE_SCALAR || luminance_source == SOURCE_VECTOR;
}

// The picture depends on the optical depth alone, and that is the segment's own: no weights.
bool depth_only() { return constant_luminance() && exact_depth; }

// Runs that need no samples: empty ones, and constant ones where L is constant along them too.
bool closed_form(Node node) {
  return node.kind == NODE_EMPTY || (constant_runs && node.kind == NODE_CONSTANT
                                     && !own_luminance());
}

real node_value(Node node) {
  return constant_runs && node.kind == NODE_CONSTANT ? fetch_constant(GRID_DENSITY, node.payload)
                                                     : real(0.0);
}

// Luminance of a separate grid: moves its node to t; a look-up follows.
March seek_luminance(March m, real t) {
  int3 cell = int3(floor(position(m.luminance_ray, t)));
  if (!inside(m.luminance_node, cell)) {
    if (inside(Node(0, 0, luminance_domain_min, luminance_domain_max), cell))
      m.luminance_node = find_node(GRID_LUMINANCE, cell);
    else
      m.luminance_node = Node(NODE_EMPTY, 1, cell, cell + 1);
  }
  if (count_steps && m.luminance_node.kind == NODE_BRICK) m.samples += 1;
  return m;
}

// L at t, where the density grid has `value`; a separate grid's node is there already.
real3 luminance_at(March m, real t, real value) {
  if (luminance_source == SOURCE_DENSITY) return real3(value, real(0.0), real(0.0));
  if (constant_luminance() || m.luminance_node.kind == NODE_EMPTY) return real3(real(0.0));
  real3 p = position(m.luminance_ray, t);
  if (luminance_source == SOURCE_SCALAR)
    return real3(sample_scalar(GRID_LUMINANCE, m.luminance_node, p), real(0.0), real(0.0));
  return sample_vector(GRID_LUMINANCE, m.luminance_node, p);
}

// Adds optical depth, compensated: 1e5 thin steps keep their sum.
March deepen(March m, real depth, real length) {
  if (find_depth && m.half_depth >= NEVER && m.optical_depth + depth > LN2)
    m.half_depth = m.t + length * ((LN2 - m.optical_depth) / depth);
  precise real y = depth - m.lost;
  precise real sum = m.optical_depth + y;
  precise real lost = (sum - m.optical_depth) - y;
  m.optical_depth = sum;
  m.lost = lost;
  if (sum > stop_depth) m.done = true;
  return m;
}

// Ends a turn. Every 16 of them the transmittance is taken from the optical depth itself: between,
// the product of T picks up as many roundings, and a long ray has no floor that grows with its
// steps.
March end_turn(March m, Ray ray) {
  m.turns += 1;
  if (!constant_luminance() && (m.turns & 15) == 0) m.transmittance = decay(m.optical_depth).e;
  if (m.t >= ray.end) m.done = true;
  return m;
}

// Composites a segment that starts at m.t: I += T C, T *= zeta = 1 - the sum of the weights.
March composite(March m, Weights w, real3 L_front, real3 L_middle, real3 L_back, real length) {
  if (count_steps && w.depth > real(0.0)) m.steps += 1;
  if (luminance_source == SOURCE_VECTOR)
    m.radiance = m.radiance
               + (L_front * w.front + L_middle * w.middle + L_back * w.back) * m.transmittance;
  else if (!constant_luminance())
    m.radiance.x += (L_front.x * w.front + L_middle.x * w.middle + L_back.x * w.back)
                  * m.transmittance;
  m.transmittance -= m.transmittance * (w.front + w.middle + w.back);
  m = deepen(m, w.depth, length);
  m.t += length;
  return m;
}

// One segment of linear or sampled values, from m.t to t_back; leaves the front of the next one.
March composite_segment(March m, real f_middle, real f_back, real t_back, real length, real depth) {
  real3 L_middle = real3(real(0.0));
  real3 L_back = real3(real(0.0));
  if (middle_rule) {
    real t_middle = t_back - real(0.5) * length;
    if (own_luminance()) m = seek_luminance(m, t_middle);
    L_middle = luminance_at(m, t_middle, f_middle);
  } else {
    if (own_luminance()) m = seek_luminance(m, t_back);
    L_back = luminance_at(m, t_back, f_back);
  }
  if (depth_only()) {
    Weights none = Weights(real(0.0), real(0.0), real(0.0), depth);
    m = composite(m, none, m.L, L_middle, L_back, length);
  } else {
    Segment segment = Segment(extinction * m.value, extinction * f_middle, extinction * f_back,
                              length, depth);
    m = composite(m, integrate_segment(segment), m.L, L_middle, L_back, length);
  }
  m.t = t_back;
  m.value = f_back;
  m.L = L_back;
  return m;
}

// A cell from m.t to t_exit by a rule that integrates its cubic from three nodes, or the first part
// of it where it is opaque; the next turn goes on from there. Runs of one value need no parts.
March composite_cell(March m, Cubic cubic, real f_exit, real t_exit, bool run) {
  real length = t_exit - m.t;
  real part = run ? real(1.0) : shallow_part(cubic, extinction * length);
  if (part < real(1.0)) {
    f_exit = evaluate(cubic, part);
    cubic = first_part(cubic, part);
    length = length * part;
    // A part too short to move t would be met again for ever.
    if (m.t + length > m.t) t_exit = m.t + length;
  }
  real t_1 = m.t + cell_node_1 * length;
  if (own_luminance()) m = seek_luminance(m, t_1);
  real3 L_1 = luminance_at(m, t_1, evaluate(cubic, cell_node_1));
  real t_2 = m.t + real(0.5) * length;
  if (own_luminance()) m = seek_luminance(m, t_2);
  real3 L_2 = luminance_at(m, t_2, evaluate(cubic, real(0.5)));
  real t_3 = m.t + cell_node_3 * length;
  if (own_luminance()) m = seek_luminance(m, t_3);
  real3 L_3 = luminance_at(m, t_3, evaluate(cubic, cell_node_3));
  m = composite(m, integrate_cell(cubic, extinction * length), L_1, L_2, L_3, length);
  m.t = t_exit;
  m.value = f_exit;
  return m;
}

// --- cells -------------------------------------------------------------------------------------

// What a turn crosses: one cell, or a whole run of one value. Simpson's rule is exact for the cubic.
March march_cells(March m, Ray ray) {
  Node node = no_node();
  for (int turn = 0; turn < max_turns && !m.done; ++turn) {
    if (!inside(node, m.cell)) node = find_node(GRID_DENSITY, m.cell);
    bool run = closed_form(node);
    Crossing far = leave(ray, run ? node.lo : m.cell, run ? node.hi : m.cell + 1);
    real f_run = node_value(node);
    real t_exit = max(m.t, min(far.t, ray.end));
    if (run) {
      m.value = f_run;
      if (!own_luminance()) m.L = luminance_at(m, m.t, f_run);
    } else if (!m.known) {
      t_exit = m.t;
    }
    real length = t_exit - m.t;
    real t_half = m.t + real(0.5) * length;
    real f_half = f_run;
    real f_exit = f_run;
    real q_3 = real(0.0);
    if (node.kind == NODE_BRICK) {
      if (hardware_filter) {  // two filtered look-ups, no third difference
        f_half = sample_scalar(GRID_DENSITY, node, position(ray, t_half));
        f_exit = sample_scalar(GRID_DENSITY, node, position(ray, t_exit));
      } else {
        Corners corners = fetch_corners(GRID_DENSITY, node, m.cell);
        real3 base = real3(m.cell);
        f_half = trilinear(corners, position(ray, t_half) - base);
        f_exit = max(trilinear(corners, position(ray, t_exit) - base), real(0.0));
        if (!depth_only()) {
          real3 d = ray.direction * length;
          q_3 = third_difference(corners) * d.x * d.y * d.z;
        }
      }
      if (count_steps) m.samples += 1;
    }
    if (!run && !m.known) {  // found, not crossed; a resumed ray has its value
      if (m.value >= real(0.0)) f_exit = m.value;
      f_half = f_exit;
      m.value = f_exit;
      far.cell = m.cell;
    }

    if (depth_only()) {
      real depth = extinction * length * (m.value + real(4.0) * f_half + f_exit) / real(6.0);
      m = composite_segment(m, f_half, f_exit, t_exit, length, max(depth, real(0.0)));
    } else if (cell_rule) {
      m = composite_cell(m, make_cubic(m.value, f_half, f_exit, q_3), f_exit, t_exit, run);
    } else {
      Cubic cubic = make_cubic(m.value, f_half, f_exit, q_3);
      real part = length / real(segments);
      real t_start = m.t;
      for (int i = 1; i <= segments; ++i) {
        real s = real(i) / real(segments);
        real f_middle = evaluate(cubic, s - real(0.5) / real(segments));
        real f_back = i == segments ? f_exit : evaluate(cubic, s);
        real t_back = i == segments ? t_exit : t_start + s * length;
        real depth = extinction * part * (m.value + real(4.0) * f_middle + f_back) / real(6.0);
        m = composite_segment(m, f_middle, f_back, t_back, part, depth);
      }
    }
    if (m.t >= t_exit) m.cell = far.cell;
    m.known = true;
    m = end_turn(m, ray);
  }
  return m;
}

// --- uniform -----------------------------------------------------------------------------------

// The rule's middle sample: usually in the node that the walk has reached, else looked up.
real sample_middle(Ray ray, Node node, real node_begin, real t_middle) {
  if (t_middle < node_begin)
    node = find_node(GRID_DENSITY,
                     cell_at(ray, t_middle, density_domain_min, density_domain_max));
  if (node.kind == NODE_EMPTY) return real(0.0);
  return sample_scalar(GRID_DENSITY, node, position(ray, t_middle));
}

// Samples at the lattice's points k * step, the domain's ends and the ends of constant runs, which
// are one segment each. Nodes are walked one by one, so that no constant run is missed however long
// the step; empty ones are left at the last lattice point inside them.
March march_uniform(March m, Ray ray) {
  Node node = no_node();
  real node_begin = m.t;
  real node_end = m.t;
  bool walk = true;
  m.cell = cell_at(ray, m.t, density_domain_min, density_domain_max);
  for (int turn = 0; turn < max_turns && !m.done; ++turn) {
    // the next lattice point behind t, which may lie on one
    if (step * real(m.lattice + 1) <= m.t) m.lattice += 1;
    real t_back = m.known ? min(step * real(m.lattice + 1), ray.end) : m.t;
    // a constant run shorter than a step is still to be crossed
    bool pending = closed_form(node) && node.kind == NODE_CONSTANT && m.t < node_end;
    if (walk || (t_back > node_end && !pending)) {
      node = find_node(GRID_DENSITY, m.cell);
      Crossing far = leave(ray, node.lo, node.hi);
      node_begin = node_end;
      node_end = max(node_begin, min(far.t, ray.end));
      m.cell = far.cell;
      walk = false;
    }
    bool run = closed_form(node) && node.kind == NODE_CONSTANT;
    real f_back = node_value(node);
    if (run) {  // the step before it ends at its face
      bool before = m.t < node_begin;
      t_back = before ? node_begin : node_end;
      if (!before) {
        m.value = f_back;
        if (!own_luminance()) m.L = luminance_at(m, m.t, f_back);
      }
    }
    if (t_back <= node_end) {
      if (node.kind == NODE_BRICK) {
        if (!middle_rule) f_back = sample_scalar(GRID_DENSITY, node, position(ray, t_back));
        if (count_steps) m.samples += 1;
      }
      if (!m.known && !run) {
        if (m.value >= real(0.0)) f_back = m.value;
        m.value = f_back;
      }
      real length = t_back - m.t;
      real f_middle = f_back;
      if (middle_rule && !(run && m.t >= node_begin))
        f_middle = sample_middle(ray, node, node_begin, m.t + real(0.5) * length);
      real depth = extinction * length * real(0.5) * (m.value + f_back);
      m = composite_segment(m, f_middle, f_back, t_back, length, depth);
      m.known = true;
      if (closed_form(node) && !(run && t_back < node_end)) {
        m.lattice = int(floor(node_end / step));
        real t_last = node_end >= ray.end ? ray.end : step * real(m.lattice);
        if (t_last > m.t) {
          m.t = t_last;
          m.known = !own_luminance();
        }
      }
    }
    m = end_turn(m, ray);
  }
  return m;
}

// --- a pixel -----------------------------------------------------------------------------------

// Where the ray of a pixel runs in a grid, in that grid's voxels.
struct Pixel {
  real u;
  real v;
  real inverse_length;  // of the world direction
};

Pixel make_pixel(real2 pixel) {
  real u = real(2.0) * (pixel.x + sample_offset.x) / image_size.x - real(1.0);
  real v = real(1.0) - real(2.0) * (pixel.y + sample_offset.y) / image_size.y;
  real3 w = world_0 + world_u * u + world_v * v;
  return Pixel(u, v, real(1.0) / sqrt(dot(w, w)));
}

real camera_time(Pixel p) {
  return orthographic ? -camera_distance : -camera_distance / p.inverse_length;
}

Ray density_ray(Pixel p) {
  return make_ray(density_anchor_0 + density_anchor_u * p.u + density_anchor_v * p.v,
                  (density_direction_0 + density_direction_u * p.u + density_direction_v * p.v)
                      * p.inverse_length,
                  density_domain_min, density_domain_max, camera_time(p));
}

Ray luminance_ray(Pixel p) {
  return make_ray(luminance_anchor_0 + luminance_anchor_u * p.u + luminance_anchor_v * p.v,
                  (luminance_direction_0 + luminance_direction_u * p.u
                   + luminance_direction_v * p.v) * p.inverse_length,
                  luminance_domain_min, luminance_domain_max, camera_time(p));
}

March begin_march(Ray ray) {
  March m;
  m.t = ray.begin;
  m.value = real(-1.0);
  m.cell = cell_at(ray, ray.begin, density_domain_min, density_domain_max);
  m.lattice = uniform_sampling ? int(floor(ray.begin / step)) : 0;
  m.known = false;
  m.L = real3(real(0.0));
  m.radiance = real3(real(0.0));
  m.optical_depth = real(0.0);
  m.lost = real(0.0);
  m.transmittance = real(1.0);
  m.half_depth = NEVER;
  m.steps = 0;
  m.samples = 0;
  m.turns = 0;
  m.done = !(ray.end > ray.begin);
  m.luminance_node = no_node();
  m.luminance_ray = ray;
  return m;
}

// Marches on, up to max_turns turns.
March march_on(March m, Pixel p, Ray ray) {
  if (own_luminance()) m.luminance_ray = luminance_ray(p);
  if (uniform_sampling) return march_uniform(m, ray);
  return march_cells(m, ray);
}

// Premultiplied radiance and opacity.
real4 picture(March m) {
  real a = decay(m.optical_depth).a;
  if (constant_luminance()) return real4(color * a, a);
  if (luminance_source == SOURCE_VECTOR) return real4(color * m.radiance, a);
  return real4(color * m.radiance.x, a);
}
