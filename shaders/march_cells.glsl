// Cells: what a turn crosses is one cell, a piece of one, or a whole run of one value. Along a ray
// trilinear data is a cubic in each cell, and Simpson's rule is exact for it.

// Where a surface is hit: shaded by the field's gradient there, from the light or from the camera.
void hit_surface(INOUT(March) m, Ray ray, Node node, real t) {
  real3 p = position(ray, t);
  real3 local = p - real3(m.cell);
  real3 g = trilinear_gradient(fetch_corners(GRID_DENSITY, node, m.cell), clamp(local, real(0.0), real(1.0)));
  real3 n = normal_x * g.x + normal_y * g.y + normal_z * g.z;
  real size = sqrt(dot(n, n));
  m.radiance = n * (size > real(0.0) ? real(1.0) / size : real(0.0));
  m.half_depth = t;
  m.done = true;
}

// Where another grid's cell, run or domain ends behind t: what a rule that integrates cubics stops at.
// Faces nearer than this [unit of t] are met: two lattices that are the same differ by rounding.
const real near_face = real(1e-4);

real next_face(Ray ray, Node node, real t) {
  t += near_face;
  if (t < ray.begin) return ray.begin;
  if (t >= ray.end) return NEVER;
  int3 cell = int3(floor(position(ray, t)));
  bool brick = node.kind == NODE_BRICK;
  return leave(ray, brick ? cell : node.lo, brick ? cell + 1 : node.hi).t;
}

// The end of the part from m.t on in which the other grids are cubics too; ahead of m.t by more than
// rounding, as part_end.
real end_of_cubics(IN(March) m, real t_end) {
  real t = NEVER;
  if (own_luminance)
    t = next_face(m.luminance_ray,
                  seek_node(GRID_LUMINANCE, m.luminance_ray, m.luminance_node, luminance_domain_min,
                            luminance_domain_max, m.t + near_face), m.t);
  if (has_emission)
    t = min(t, next_face(m.emission_ray,
                         seek_node(GRID_EMISSION, m.emission_ray, m.emission_node,
                                   emission_domain_min, emission_domain_max, m.t + near_face), m.t));
  if (t >= t_end - near_face) return t_end;
  return min(t_end, max(t, m.t + abs(m.t) * t_epsilon + t_epsilon));
}

// The gradient's magnitude along the cell, from m.t on; its node is there already.
Cubic gradient_along(IN(March) m, Ray ray, real length) {
  Node node = m.gradient_node;
  if (!with_gradient || m.vacuum || node.kind == NODE_EMPTY)
    return Cubic(real(0.0), real(0.0), real(0.0), real(0.0));
  real3 front = position(ray, m.t);
  real3 half_way = position(ray, m.t + real(0.5) * length);
  real3 back = position(ray, m.t + length);
  if (hardware_filter)
    return make_cubic(sample_scalar(GRID_GRADIENT, node, front),
                      sample_scalar(GRID_GRADIENT, node, half_way),
                      sample_scalar(GRID_GRADIENT, node, back), real(0.0));
  Corners corners = fetch_corners(GRID_GRADIENT, node, m.cell);
  real3 base = real3(m.cell);
  real3 d = ray.direction * length;
  return make_cubic(trilinear(corners, front - base), trilinear(corners, half_way - base),
                    trilinear(corners, back - base),
                    third_difference(corners) * d.x * d.y * d.z);
}

Sample sample_cubics(Cubic value, Cubic slope, real s) {
  return Sample(polynomial(value, s), max(polynomial(slope, s), real(0.0)));
}

void march_cells(INOUT(March) m, Ray ray) {
  Node node = no_node();
  for (int turn = 0; turn < max_turns && !m.done;) {
    for (int n = 0; n < turns_of_product && turn < max_turns && !m.done; ++n, ++turn) {
      if (!inside(node, m.cell)) node = find_node(GRID_DENSITY, m.cell);
      bool run = closed_form(node);
      m.vacuum = node.kind == NODE_EMPTY || beyond_density(m.cell);
      Crossing far = leave(ray, run ? node.lo : m.cell, run ? node.hi : m.cell + 1);
      real f_run = node_value(node);
      real t_exit = max(m.t, min(far.t, ray.end));
      if (!run && !m.known) t_exit = m.t;
      real length = t_exit - m.t;
      real t_half = m.t + real(0.5) * length;
      // a constant's neighbour may have been skipped as of no attenuation, whatever its value
      real f_front = node.kind == NODE_BRICK ? m.front.value : f_run;
      real f_half = f_run;
      real f_exit = f_run;
      real q_3 = real(0.0);
      real noise = real(0.0);
      if (node.kind == NODE_BRICK) {
        if (hardware_filter) {  // filtered look-ups, no third difference
          f_half = sample_scalar(GRID_DENSITY, node, position(ray, t_half));
          f_exit = sample_scalar(GRID_DENSITY, node, position(ray, t_exit));
          if (transfer) f_front = sample_scalar(GRID_DENSITY, node, position(ray, m.t));
          noise = real(8.0) * t_epsilon * max(abs(f_half), max(abs(f_front), abs(f_exit)));
        } else {
          Corners corners = fetch_corners(GRID_DENSITY, node, m.cell);
          real3 base = real3(m.cell);
          f_half = trilinear(corners, position(ray, t_half) - base);
          f_exit = trilinear(corners, position(ray, t_exit) - base);
          if (!transfer) f_exit = max(f_exit, real(0.0));
          // where it comes from may have been skipped as of no attenuation, whatever its value
          if (transfer) f_front = trilinear(corners, position(ray, m.t) - base);
          if (transfer && split_knots)
            noise = real(8.0) * t_epsilon * greatest_magnitude(corners);
          if (!depth_only || transfer) {
            real3 d = ray.direction * length;
            q_3 = third_difference(corners) * d.x * d.y * d.z;
          }
        }
        if (count_steps) m.samples += 1;
      }
      if (!run && !m.known) {  // found, not crossed; a resumed ray has its value
        if (m.front.value > UNKNOWN) f_exit = m.front.value;
        f_front = f_exit;
        f_half = f_exit;
        far.cell = m.cell;
      }

      Cubic value = make_cubic(f_front, f_half, f_exit, q_3);
      if (!m.vacuum) seek_gradient(m, m.cell);
      Cubic slope = gradient_along(m, ray, length);
      Cubic attenuation = value;
      real t_end = t_exit;
      if (transfer && split_knots && !run) {
        Piece piece = piece_between_knots(value, noise);
        attenuation = Cubic(piece.a + piece.b * value.f_0, piece.b * value.q_1, piece.b * value.q_2,
                            piece.b * value.q_3);
        t_end = part_end(m.t, length, piece.part, t_exit);
        m.interval = piece.interval;
        if (m.vacuum) attenuation = Cubic(real(0.0), real(0.0), real(0.0), real(0.0));
      } else if (transfer) {
        if (keeps_interval) m.interval = transfer_interval(f_run);
        attenuation = Cubic(attenuation_of(m, Sample(f_run, real(0.0))), real(0.0), real(0.0), real(0.0));
        if (m.vacuum) attenuation.f_0 = real(0.0);
      }
      m.front = with_value(m, m.front, Sample(f_front, max(slope.f_0, real(0.0))));
      if (cell_rule && !run && !depth_only) {
        real x = extinction * length;
        real values = greatest_coefficient(value);
        // between knots a value is monotone, but for rounding: it may end where it began
        if (transfer && length > real(0.0))
          values = max(abs(polynomial(value, (t_end - m.t) / length) - f_front), noise);
        real part = min(shallow_part(attenuation, x), smooth_part(value, attenuation, x, values));
        t_end = end_of_cubics(m, min(t_end, part_end(m.t, length, part, t_exit)));
      }
      if (t_end < t_exit) {
        real part = (t_end - m.t) / length;
        value = first_part(value, part);
        attenuation = first_part(attenuation, part);
        f_exit = polynomial(value, real(1.0));
        length = t_end - m.t;
      }

      if (finds_maximum) {
        see_cell(m, value, t_end);
      } else if (mode == MODE_ISOSURFACE) {
        real s = first_crossing(value, isovalue);
        if (node.kind == NODE_BRICK && s <= real(1.0)) hit_surface(m, ray, node, m.t + s * length);
        m.t = t_end;
        m.front.value = f_exit;
      } else if (cell_rule && !depth_only) {
        composite_cell(m, value, attenuation, t_end, length);
      } else if (depth_only && !transfer) {
        composite_segment(m, Sample(f_half, real(0.0)), Sample(f_exit, real(0.0)), t_end, length, run);
      } else {
        real part = length / real(segments);
        real t_start = m.t;
        for (int i = 1; i <= segments; ++i) {
          real s = real(i) / real(segments);
          Sample middle = sample_cubics(value, slope, s - real(0.5) / real(segments));
          Sample back = sample_cubics(value, slope, s);
          if (i == segments) back.value = f_exit;
          if (!transfer) {
            middle.value = max(middle.value, real(0.0));
            back.value = max(back.value, real(0.0));
          }
          real t_back = i == segments ? t_end : t_start + s * length;
          composite_segment(m, middle, back, t_back, part, run);
        }
      }
      if (m.t >= t_exit) m.cell = far.cell;
      // bricks without the isovalue are empty too, whatever their values
      m.known = !(mode == MODE_ISOSURFACE && m.vacuum);
      if (!m.known) m.front.value = UNKNOWN;
      end_turn(m, ray);
    }
    refresh_transmittance(m);
  }
}
