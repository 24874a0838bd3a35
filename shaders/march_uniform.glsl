// Uniform: samples at the lattice's points k * step, the domain's ends and the ends of constant runs,
// which are one segment each. Nodes are walked one by one, so that no constant run is missed however
// long the step; empty ones are left at the last lattice point inside them. With `brick_steps` each
// brick has a part of the step of its own.

// What a brick may miss grows by e^d behind an optical depth d, and the step that misses it by e^{d/2} at
// least; of that e^{d/4} is taken, as a lower bound of it: all of it put one pixel in a thousand of a dense
// cloud beyond five tolerances.
real wider_behind(real d) {
  real x = real(1.0) + d / real(16.0);
  x *= x;
  return x * x;
}

// Step of the lattice in a node that begins behind the ray's optical depth.
real node_step(Node node, IN(March) m) {
  if (!brick_steps || node.kind != NODE_BRICK) return step;
  real part = fetch_table(brick_steps_first + node.payload).x;
  if (mode == MODE_ALPHA) part = min(part * wider_behind(m.optical_depth), real(1.0));
  return step * part;
}

// The first point of the lattice of step h behind t, which may lie on one.
real next_point(real t, real h) {
  real k = floor(t / h) + real(1.0);
  real point = h * k;
  return point > t ? point : h * (k + real(1.0));
}

// Where a segment's look-up is, and with it the node that the walk has to reach.
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
  if (!with_gradient || m.gradient_node.kind == NODE_EMPTY) return real(0.0);
  return sample_scalar(GRID_GRADIENT, m.gradient_node, position(ray, t));
}

// Slopes along the ray at m.t of what its point holds; `slope`: the density's.
void find_slopes(INOUT(March) m, real slope) {
  m.front.slope = slope;
  if (luminance_source == SOURCE_DENSITY) m.front.L_slope = real3(m.front.slope);
  if (luminance_source == SOURCE_SCALAR)
    m.front.L_slope = real3(slope_scalar(GRID_LUMINANCE, m.luminance_node, m.luminance_ray, m.t));
  if (luminance_source == SOURCE_VECTOR)
    m.front.L_slope = slope_vector(GRID_LUMINANCE, m.luminance_node, m.luminance_ray, m.t);
}

void march_uniform(INOUT(March) m, Ray ray) {
  // where the density's own medium begins and ends
  real own_begin = ray.begin;
  real own_end = ray.end;
  if (beyond) {
    own_begin = greatest(face_times(ray, far_faces(ray, density_field_max, density_field_min)));
    own_end = least(face_times(ray, far_faces(ray, density_field_min, density_field_max)));
  }
  Node node = no_node();
  real node_begin = m.t;
  real node_end = m.t;
  real h = step;     // of the node
  real finest = step;  // of the nodes since t
  bool walk = true;
  if (walks_middles) m.known = true;  // no value at its front is asked for
  m.cell = cell_at(ray, m.t, density_domain_min, density_domain_max);
  for (int turn = 0; turn < max_turns && !m.done;) {
    for (int n = 0; n < turns_of_product && turn < max_turns && !m.done; ++n, ++turn) {
      real t_back = m.known ? min(next_point(m.t, finest), ray.end) : m.t;
      if (beyond && m.t < own_end) t_back = min(t_back, m.t < own_begin ? max(own_begin, m.t) : own_end);
      // a constant run shorter than a step is still to be crossed
      bool pending = constant_run(node) && m.t < node_end;
      if (walk || (look_up_at(m.t, t_back) > node_end && !pending)) {
        node = find_node(GRID_DENSITY, m.cell);
        Crossing far = leave(ray, node.lo, node.hi);
        node_begin = node_end;
        node_end = max(node_begin, min(far.t, ray.end));
        m.cell = far.cell;
        walk = false;
        h = node_step(node, m);
        finest = min(finest, h);
      }
      if (brick_steps && m.known) t_back = min(t_back, next_point(max(m.t, node_begin), finest));
      m.vacuum = node.kind == NODE_EMPTY;
      bool run = constant_run(node);
      real f_back = node_value(node);
      if (run) {  // the step before it ends at its face
        bool before = m.t < node_begin;
        t_back = before ? node_begin : node_end;
        if (!before) m.front = with_value(m, m.front, Sample(f_back, real(0.0)));
      }
      bool outside = beyond && (m.t < own_begin || t_back > own_end);
      if (beyond) {
        m.vacuum = m.vacuum || outside;
        seek_gradient_at(m, ray, m.t);
        m.front = with_value(m, m.front, Sample(m.front.value, sample_gradient(m, ray, m.t)));
      }
      if (look_up_at(m.t, t_back) <= node_end) {
        real slope = real(0.0);
        if (node.kind == NODE_BRICK) {
          if (end_corrections) {
            Tangent back = tangent_scalar(GRID_DENSITY, node, ray, t_back);
            f_back = back.value;
            slope = back.slope;
          } else if (!middle_rule) {
            f_back = sample_scalar(GRID_DENSITY, node, position(ray, t_back));
          }
          if (count_steps) m.samples += 1;
        }
        real length = t_back - m.t;
        Sample middle = Sample(f_back, real(0.0));
        if ((middle_rule || has_emission) && !(run && m.t >= node_begin)) {
          real t_middle = m.t + real(0.5) * length;
          Node at = node;
          if (!walks_middles && t_middle < node_begin)
            at = find_node(GRID_DENSITY,
                           cell_at(ray, t_middle, density_domain_min, density_domain_max));
          middle.value = real(0.0);
          if (at.kind != NODE_EMPTY)
            middle.value = sample_scalar(GRID_DENSITY, at, position(ray, t_middle));
          if (middle_rule) m.vacuum = at.kind == NODE_EMPTY || outside;
          seek_gradient_at(m, ray, t_middle);
          middle.gradient = sample_gradient(m, ray, t_middle);
        }
        seek_gradient_at(m, ray, t_back);
        Sample back = Sample(f_back, sample_gradient(m, ray, t_back));
        if (!m.known && !run) {
          if (m.front.value > UNKNOWN) back.value = m.front.value;
          m.front.value = back.value;  // all of it that a segment of length 0 is asked for
        }
        if (finds_maximum) {
          see_value(m, m.front.value, m.t);
          see_value(m, back.value, t_back);
          m.t = t_back;
          m.front.value = back.value;
        } else {
          composite_segment(m, middle, back, t_back, length, run && m.t >= node_begin);
          if (end_corrections) find_slopes(m, slope);
        }
        m.known = true;
        finest = h;
        if (closed_form(node) && !(run && t_back < node_end)) {
          // the lattice of what comes next may be finer: its own begins at the face
          real t_last = node_end >= ray.end || brick_steps ? node_end : step * floor(node_end / step);
          if (t_last > m.t) {
            m.t = t_last;
            m.known = !own_luminance;
          }
        }
      }
      end_turn(m, ray);
    }
    refresh_transmittance(m);
  }
  // the last step's own end; a ray that ended early has no more to correct
  if (end_corrections && m.t >= ray.end && m.turns > 0) {
    real length = sqrt(real(12.0) * m.step_error);
    correct_step(m, m.step_error, extinction * m.front.attenuation * length);
  }
}
