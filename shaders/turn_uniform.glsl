// Uniform: samples at the lattice's points k * step, at the domain's ends and at the ends of constant
// runs, each of which is one segment. The walk visits every node, so that no step is too long to see a
// constant run; it leaves an empty node at the last lattice point inside. With `brick_steps` each brick
// has its own part of the step.

// Behind an optical depth d a brick's error may be e^d times as large, so its step may be at least
// e^{d/2} times as long. This takes a lower bound of e^{d/4}: with e^{d/2} one pixel in a thousand of a
// dense cloud was off by more than five tolerances.
real wider_behind(real d) {
  real x = real(1.0) + d / real(16.0);
  x *= x;
  return x * x;
}

// Step of the lattice in a node that begins behind the ray's optical depth.
real node_step(Node node, IN(March) m) {
  real h = step;
  if (brick_steps && node.kind == NODE_BRICK) {
    real part = table_number(brick_steps_first, node.payload);
    if (shows == SHOWS_light && !from_back) part = min(part * wider_behind(m.optical_depth), real(1.0));
    h = step * part;
  }
  return h;
}

// The first point of the lattice of step h behind t, which may lie on one. It is behind t whatever
// rounding makes of the quotient; `precise`, since the product that is compared is the one returned.
real next_point(real t, real h) {
  real k = floor(t / h) + real(1.0);
  precise real point = h * k;
  precise real next = h * (k + real(1.0));
  return point > t ? point : next;
}

// Where a segment's look-up is: the walk has to reach the node there.
real look_up_at(real t, real t_back) {
  return walks_middles ? t + real(0.5) * (t_back - t) : t_back;
}

// Moves the gradient's node to t; the domain's ends are in its last cells.
void seek_gradient_at(INOUT(March) m, Ray ray, real t) {
  if (!with_gradient) return;
  seek_gradient(m, cell_at(ray, t, density_field_min, density_field_max));
}

// The gradient's magnitude at t.
real sample_gradient(IN(March) m, Ray ray, real t) {
  real v = real(0.0);
  if (with_gradient && m.gradient.node.kind != NODE_EMPTY)
    v = sample_scalar(gradient_grid, m.gradient.node, position(ray, t));
  return v;
}

// The slopes along the ray at m.t; `slope`: the density's.
void find_slopes(INOUT(March) m, real slope) {
  m.front.slope = slope;
  if (luminance_source == SOURCE_DENSITY) m.front.L_slope = real3(m.front.slope);
  if (beside_density && !hardware_filter)
    m.front.L_slope = paired_slope(m, m.t);
  else if (luminance_source == SOURCE_SCALAR)
    m.front.L_slope = real3(slope_scalar(luminance_grid, m.luminance.node, m.luminance.ray, m.t));
  else if (luminance_source == SOURCE_VECTOR)
    m.front.L_slope = slope_vector(luminance_grid, m.luminance.node, m.luminance.ray, m.t);
}

// A walk in steps.
struct StepWalk {
  Node node;        // the walk has reached
  real node_begin;  // the part of the ray inside it
  real node_end;
  real h;           // step of the lattice in it
  real finest;      // least step of the nodes since m.t
  bool onward;      // the next turn looks up the next node
  real own_begin;   // the part of the ray inside the density's own box
  real own_end;
  real part_begin;  // in_part: the part of the ray inside the region, where its segments begin
  real part_end;
};

// When the ray crosses faces between regions. It has crossed those that it begins in, but for rounding:
// in front of such a face would be a step of a region that comes later. `precise`: where one region ends
// and where the next begins is one number.
real part_time(Ray ray, real t, real inverse) {
  real size = greatest(real3(density.domain_max - density.domain_min)) + abs(ray.begin);
  precise real noise = abs(inverse) * (real(8.0) * t_epsilon * size);
  precise real crossed = ray.begin + noise;
  return t > crossed ? t : min(t, ray.begin);
}

real3 part_times(Ray ray, int3 faces) {
  real3 t = face_times(ray, faces);
  return real3(part_time(ray, t.x, ray.inverse.x), part_time(ray, t.y, ray.inverse.y),
               part_time(ray, t.z, ray.inverse.z));
}

StepWalk begin_steps(INOUT(March) m, Ray ray) {
  if (walks_middles) m.known = true;  // no segment reads a value at its front
  m.cell = cell_at(ray, m.t, density.domain_min, density.domain_max);
  StepWalk w = StepWalk(no_node(), m.t, m.t, step, step, true, ray.begin, ray.end, ray.begin, ray.end);
  if (beyond) {
    w.own_begin = greatest(face_times(ray, far_faces(ray, density_field_max, density_field_min)));
    w.own_end = least(face_times(ray, far_faces(ray, density_field_min, density_field_max)));
  }
  if (in_part) {
    w.part_begin = greatest(part_times(ray, far_faces(ray, part_max, part_min)));
    w.part_end = least(part_times(ray, far_faces(ray, part_min, part_max)));
  }
  return w;
}

// Whether a segment that begins at t belongs to the region. It belongs to exactly one.
bool begins_in_part(StepWalk w, real t) {
  return !in_part || (t >= w.part_begin && t < w.part_end);
}

// A run ends at the region's faces, where another region's part of it begins.
Crossing cut_at_part(StepWalk w, Ray ray, Crossing far) {
  real face = w.node_end < w.part_begin ? w.part_begin : w.part_end;
  if (face > w.node_end && face < far.t) {
    int3 cell = cell_at(ray, face, w.node.lo, w.node.lo + w.node.side);
    far = Crossing(face, cell_between_faces(ray, face, cell));
  }
  return far;
}

// The walk goes on to the node of m.cell.
void enter_node(INOUT(March) m, INOUT(StepWalk) w, Ray ray) {
  w.node = sampled_node(find_node(density_grid, m.cell), m.cell);
  Crossing far = leave(ray, w.node.lo, w.node.side);
  if (in_part && constant_run(w.node)) far = cut_at_part(w, ray, far);
  w.node_begin = w.node_end;
  w.node_end = max(w.node_begin, min(far.t, ray.end));
  m.cell = far.cell;
  w.onward = false;
  w.h = node_step(w.node, m);
  w.finest = min(w.finest, w.h);
}

// The step of a turn, from m.t on.
struct Step {
  real t_back;
  bool run;      // inside a constant run, which one segment crosses
  bool outside;  // the density's own box
};

// The next sample: at a lattice point or an end of the density's own box. Looks up the node there.
real next_sample(INOUT(March) m, INOUT(StepWalk) w, Ray ray) {
  real t_back = m.known ? min(next_point(m.t, w.finest), ray.end) : m.t;
  if (beyond && m.t < w.own_end)
    t_back = min(t_back, m.t < w.own_begin ? max(w.own_begin, m.t) : w.own_end);
  // a constant run shorter than a step is still to be crossed
  bool pending = constant_run(w.node) && m.t < w.node_end;
  if (w.onward || (look_up_at(m.t, t_back) > w.node_end && !pending)) enter_node(m, w, ray);
  if (brick_steps && m.known) t_back = min(t_back, next_point(max(m.t, w.node_begin), w.finest));
  return t_back;
}

Step find_step(INOUT(March) m, INOUT(StepWalk) w, Ray ray) {
  Step s = Step(next_sample(m, w, ray), false, false);
  m.vacuum = w.node.kind == NODE_EMPTY;
  if (constant_run(w.node)) {  // the step before it ends at its face
    s.run = m.t >= w.node_begin;
    s.t_back = s.run ? w.node_end : w.node_begin;
    if (s.run) m.front = with_value(m, m.front, Sample(node_value(w.node), real(0.0)));
  }
  if (beyond) {
    s.outside = m.t < w.own_begin || s.t_back > w.own_end;
    m.vacuum = m.vacuum || s.outside;
    seek_gradient_at(m, ray, m.t);
    m.front = with_value(m, m.front, Sample(m.front.value, sample_gradient(m, ray, m.t)));
  }
  return s;
}

// The density in a brick at t. Where the luminance beside it counts too, reads both.
real sample_brick(INOUT(March) m, Node brick, Ray ray, real t, bool luminous) {
  real3 p = position(ray, t);
  if (!beside_density || !luminous) return sample_scalar(density_grid, brick, p);
  read_pairs(m, brick, first_cell(brick) + local_cell(brick, p - real3(first_cell(brick))));
  if (hardware_filter) return sample_scalar(density_grid, brick, p);
  return trilinear(densities(m.pairs), p - m.pairs_at);
}

// The density in the middle of a step, whose node may be one before the walk's.
Sample sample_middle(INOUT(March) m, StepWalk w, Step s, Ray ray) {
  real t = m.t + real(0.5) * (s.t_back - m.t);
  Node node = w.node;
  if (!walks_middles && t < w.node_begin) {
    int3 cell = cell_at(ray, t, density.domain_min, density.domain_max);
    node = sampled_node(find_node(density_grid, cell), cell);
  }
  real value = node_value(node);
  if (node.kind == NODE_BRICK) value = sample_brick(m, node, ray, t, middle_rule);
  if (middle_rule) m.vacuum = node.kind == NODE_EMPTY || s.outside;
  seek_gradient_at(m, ray, t);
  return Sample(value, sample_gradient(m, ray, t));
}

// What the samples of a step give.
struct Samples {
  Sample middle;
  Sample back;
  real slope;  // of the density along the ray at the back
};

// Samples a step whose node is found.
Samples sample_step(INOUT(March) m, StepWalk w, Step s, Ray ray) {
  Tangent end = Tangent(node_value(w.node), real(0.0));
  if (w.node.kind == NODE_BRICK) {
    if (end_corrections) end = tangent_scalar(density_grid, w.node, ray, s.t_back);
    if (!middle_rule && (!end_corrections || beside_density))
      end.value = sample_brick(m, w.node, ray, s.t_back, true);
    m.samples += look_ups(w.node);
  }
  Sample middle = Sample(end.value, real(0.0));
  if ((middle_rule || has_emission) && !s.run) middle = sample_middle(m, w, s, ray);
  seek_gradient_at(m, ray, s.t_back);
  Sample back = Sample(end.value, sample_gradient(m, ray, s.t_back));
  if (!m.known && !constant_run(w.node)) {
    if (m.front.value > UNKNOWN) back.value = m.front.value;
    m.front.value = back.value;  // a segment of length 0 reads nothing else
  }
  return Samples(middle, back, end.slope);
}

// Goes to the end of an empty node, or of a run that is crossed: the next lattice may be finer, and
// begins at its own face.
void leave_run(INOUT(March) m, INOUT(StepWalk) w, Ray ray) {
  // A rule that integrates between values needs the one at the face, which the next node has.
  if (transfer_rule && w.node.kind == NODE_EMPTY && w.node_end < ray.end) {
    m.t = max(m.t, w.node_end);
    m.front.value = UNKNOWN;
    m.known = false;
    w.onward = true;
  } else {
    bool to_the_end = w.node_end >= ray.end || brick_steps;
    real t_last = to_the_end ? w.node_end : step * floor(w.node_end / step);
    if (t_last > m.t) {
      m.t = t_last;
      m.known = !tracks_luminance;
    }
  }
}

void turn_uniform(INOUT(March) m, INOUT(StepWalk) w, Ray ray) {
  // in another pass: the node that begins at t may have another slope than the one that ended there
  bool resumed = !m.known && m.front.value > UNKNOWN;
  real slope = m.front.slope;
  Step s = find_step(m, w, ray);
  m.own = begins_in_part(w, m.t);
  m.paired_here = false;
  if (look_up_at(m.t, s.t_back) <= w.node_end) {  // else the next turn looks up the next node
    Samples found = sample_step(m, w, s, ray);
    cross_step(m, found.middle, found.back, s.t_back, s.run);
    if (end_corrections) find_slopes(m, resumed ? slope : found.slope);
    m.known = true;
    w.finest = w.h;
    bool crossed = !constant_run(w.node) || s.t_back >= w.node_end;
    if (closed_form(w.node) && crossed) leave_run(m, w, ray);
  }
}

// The end of the last step; a ray that ended early has nothing left to correct.
void end_steps(INOUT(March) m, StepWalk w, Ray ray) {
  if (!end_corrections || m.t < ray.end || !begins_in_part(w, m.t)) return;
  real length = sqrt(real(12.0) * m.step_error);
  correct_step(m, m.step_error, extinction * m.front.attenuation * length);
}
