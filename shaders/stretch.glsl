// What a turn of the sampling by cells crosses: one cell, a piece of a cell, or a whole run of one value.
// Trilinear data along a ray is a cubic in each cell, and Simpson's rule is exact for it.

// The end of a piece before t_end that a face at t cuts, ahead of m.t by more than rounding (see
// part_end).
real piece_end(IN(March) m, real t, real t_end) {
  real end = min(t_end, max(t, m.t + abs(m.t) * t_epsilon + t_epsilon));
  return t >= t_end - near_face ? t_end : end;
}

// How far the other grids are cubics too, from m.t on: at most t_end.
real end_of_cubics(IN(March) m, real t_end) {
  real t = NEVER;
  if (tracks_luminance) t = next_face(luminance_grid, m.luminance, m.t);
  if (has_emission) t = min(t, emission_face(m.emission, m.t));
  return piece_end(m, t, t_end);
}

// The gradient's magnitude along the cell, from m.t on. Follows seek_gradient.
Cubic gradient_along(IN(March) m, Ray ray, real length) {
  Node node = m.gradient.node;
  if (!with_gradient || m.vacuum || node.kind == NODE_EMPTY)
    return Cubic(real(0.0), real(0.0), real(0.0), real(0.0));
  real3 front = position(ray, m.t);
  real3 half_way = position(ray, m.t + real(0.5) * length);
  real3 back = position(ray, m.t + length);
  if (hardware_filter)
    return make_cubic(sample_scalar(gradient_grid, node, front),
                      sample_scalar(gradient_grid, node, half_way),
                      sample_scalar(gradient_grid, node, back), real(0.0));
  Corners corners = fetch_corners(gradient_grid, node, in_brick(m.cell));
  real3 base = real3(m.cell);
  real3 d = ray.direction * length;
  return make_cubic(trilinear(corners, front - base), trilinear(corners, half_way - base),
                    trilinear(corners, back - base),
                    third_difference(corners) * d.x * d.y * d.z);
}

Sample sample_cubics(Cubic value, Cubic slope, real s) {
  return Sample(polynomial(value, s), max(polynomial(slope, s), real(0.0)));
}

// What a turn looks at: the ray from m.t to the far face of a cell or of a run.
struct Stretch {
  bool run;           // of one value, or empty: nothing is sampled
  int3 next;          // the cell behind the far face,
  bool leaves;        // which is in another node
  real t_exit;        // at the far face; m.t where the ray's first value is looked up, and nothing crossed
  real t_end;         // end of the piece that the turn crosses, t_exit at most
  real extent;        // length of the stretch, later of the piece
  real f_run;         // value of the run, 0 of a brick
  real f_front;       // values of the density at m.t, half way to t_exit, and there; later at t_end
  real f_half;
  real f_end;
  real q_3;           // third-order coefficient of their cubic
  real noise;         // rounding error of the values
  Cubic value;        // of the density
  Cubic slope;        // magnitude of the gradient
  Cubic attenuation;  // tau / extinction
};

Stretch find_stretch(INOUT(March) m, Node node, Ray ray) {
  m.vacuum = node.kind == NODE_EMPTY || beyond_density(m.cell);
  if (in_part) m.own = inside_box(part_min, part_max, m.cell);
  Stretch s;
  s.run = closed_form(node);
  Crossing far = leave(ray, s.run ? node.lo : m.cell, s.run ? node.side : 1);
  s.next = far.cell;
  if (in_part && s.run) s.next = cell_between_faces(ray, far.t, far.cell);
  // here, so that the turn need not keep both cells; constants lie at multiples of a brick's cells
  s.leaves = s.run || !in_one_cube(min(node.side, BRICK_CELLS), m.cell, s.next);
  s.t_exit = max(m.t, min(far.t, ray.end));
  if (!front_is_free && !s.run && !m.known) s.t_exit = m.t;
  s.t_end = s.t_exit;
  s.extent = s.t_exit - m.t;
  s.f_run = node_value(node);
  // a constant's neighbour may have been skipped because it attenuates nothing, whatever its value
  s.f_front = node.kind == NODE_BRICK ? m.front.value : s.f_run;
  s.f_half = s.f_run;
  s.f_end = s.f_run;
  s.q_3 = real(0.0);
  s.noise = real(0.0);
  s.value = Cubic(s.f_run, real(0.0), real(0.0), real(0.0));
  return s;
}

// The density along a cell of a brick.
void sample_stretch(INOUT(Stretch) s, INOUT(March) m, Node node, Ray ray) {
  real t_half = m.t + real(0.5) * s.extent;
  if (beside_density) {
    read_pairs(m, node, m.cell);
    if (!cell_rule) m.front.L = paired_luminance(m, m.t);
    m.paired_front = true;
  }
  if (hardware_filter) {  // the driver's look-ups give no third difference
    s.f_half = sample_scalar(density_grid, node, position(ray, t_half));
    s.f_end = sample_scalar(density_grid, node, position(ray, s.t_exit));
    if (transfer) s.f_front = sample_scalar(density_grid, node, position(ray, m.t));
    s.noise = real(8.0) * t_epsilon * max(abs(s.f_half), max(abs(s.f_front), abs(s.f_end)));
    return;
  }
  Corners corners;
  if (beside_density) corners = densities(m.pairs);
  else corners = fetch_corners(density_grid, node, in_brick(m.cell));
  real3 base = real3(m.cell);
  if (transfer && split_knots) s.noise = real(8.0) * t_epsilon * greatest_magnitude(corners);
  if (from_corners) {
    s.value = cubic_along(corners, position(ray, m.t) - base, ray.direction * s.extent);
    // the cell before may have been skipped because it attenuates nothing, whatever its value
    s.f_front = s.value.f_0;
    s.f_half = polynomial(s.value, real(0.5));
    s.f_end = polynomial(s.value, real(1.0));
    return;
  }
  s.f_half = trilinear(corners, position(ray, t_half) - base);
  s.f_end = trilinear(corners, position(ray, s.t_end) - base);
  if (integrates && !transfer) s.f_end = max(s.f_end, real(0.0));
  if (transfer || nearest) s.f_front = trilinear(corners, position(ray, m.t) - base);
  real3 d = ray.direction * s.extent;
  s.q_3 = third_difference(corners) * d.x * d.y * d.z;
}

// The ray's first value: it is looked up and nothing is crossed. A resumed ray has it already.
void find_front(INOUT(Stretch) s, IN(March) m) {
  if (m.front.value > UNKNOWN) s.f_end = m.front.value;
  s.f_front = s.f_end;
  s.f_half = s.f_end;
  s.next = m.cell;
  s.leaves = false;
}

// The attenuation along the stretch. With split_knots it is a cubic up to the value's next knot, where
// the piece ends; else only a run's is found here.
void classify_stretch(INOUT(Stretch) s, INOUT(March) m) {
  s.attenuation = s.value;
  if (!transfer) return;
  if (split_knots && !s.run) {
    Piece piece = piece_between_knots(s.value, s.noise);
    s.attenuation = Cubic(piece.a + piece.b * s.value.f_0, piece.b * s.value.q_1,
                          piece.b * s.value.q_2, piece.b * s.value.q_3);
    s.t_end = part_end(m.t, s.extent, piece.part, s.t_end);
    m.interval = piece.interval;
    if (m.vacuum) s.attenuation = Cubic(real(0.0), real(0.0), real(0.0), real(0.0));
  } else {
    if (keeps_interval) m.interval = transfer_interval(s.f_run);
    real attenuation = attenuation_of(m, Sample(s.f_run, real(0.0)));
    s.attenuation = Cubic(m.vacuum ? real(0.0) : attenuation, real(0.0), real(0.0), real(0.0));
  }
}

// Cuts the cubics to the piece.
void cut_piece(INOUT(Stretch) s, INOUT(March) m) {
  if (s.t_end < s.t_exit) {
    real part = (s.t_end - m.t) / s.extent;
    s.value = first_part(s.value, part);
    s.attenuation = first_part(s.attenuation, part);
    if (other_volumes > 0) m.others = first_part(m.others, part);
    s.f_end = polynomial(s.value, real(1.0));
    s.extent = s.t_end - m.t;
  }
}

// Adds the further volumes along the piece, which ends where one of them leaves a cell.
void add_others(INOUT(Stretch) s, INOUT(March) m, Ray ray) {
  Others o = others_from(ray, m.t, m.phase);
  s.t_end = piece_end(m, o.end, s.t_end);
  cut_piece(s, m);
  m.others = first_part(o, s.extent);
  s.attenuation = sum_of(s.attenuation, m.others.attenuation);
}

// Ends the piece where a rule that integrates cubics would lose accuracy: where it becomes opaque, and
// where another grid's cubic ends.
void limit_piece(INOUT(Stretch) s, INOUT(March) m, Ray ray) {
  if (other_volumes > 0) add_others(s, m, ray);
  if (deep_cells) {
    real part = shallow_part(s.attenuation, extinction * s.extent, piece_depth);
    s.t_end = min(s.t_end, part_end(m.t, s.extent, part, s.t_exit));
  }
  if (tracks_luminance || has_emission) s.t_end = end_of_cubics(m, s.t_end);
}

// The piece as linear segments of equal length.
void composite_segments(INOUT(March) m, Stretch s) {
  real part = s.extent / real(segments);
  real t_start = m.t;
  for (int i = 1; i <= segments; ++i) {
    real at = real(i) / real(segments);
    Sample middle = sample_cubics(s.value, s.slope, at - real(0.5) / real(segments));
    Sample back = sample_cubics(s.value, s.slope, at);
    if (i == segments) back.value = s.f_end;
    if (!transfer) {
      middle.value = max(middle.value, real(0.0));
      back.value = max(back.value, real(0.0));
    }
    real t_back = i == segments ? s.t_end : t_start + at * s.extent;
    composite_segment(m, middle, back, t_back, part, s.run);
  }
}

// The light and the optical depth of a piece.
void composite_stretch(INOUT(March) m, Stretch s) {
  if (cell_rule && !depth_only) {
    composite_cell(m, s.value, s.attenuation, s.t_end, s.extent);
  } else if (depth_only && !transfer && from_corners) {
    composite_depth(m, s.attenuation, s.t_end, s.extent);
  } else if (depth_only && !transfer) {
    composite_segment(m, Sample(s.f_half, real(0.0)), Sample(s.f_end, real(0.0)), s.t_end, s.extent,
                      s.run);
  } else {
    composite_segments(m, s);
  }
}
