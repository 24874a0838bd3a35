// Surfaces of values, shaded and composited from the front; a ray ends at the first opaque one. Its light
// and what it lets through are in radiance and transmittance, the number of the opaque surface from 1 on in
// `lost`, below 0 if values fall there, and its place in t.

// The density at a point of a cell; NaN where it is absent.
real density_at(int3 cell, real3 p) {
  int3 near = clamp(cell, density.domain_min, density.domain_max - 1);
  Node node = sampled_node(find_stored(density_grid, near), near);
  if (is_absent(node)) return real_of_bits(0x7fc00000u);
  return node.kind == NODE_EMPTY ? real(0.0) : sample_scalar(density_grid, node, p);
}

// Where the ray hits a surface, in a cell: its normal in the world, 0 where the field has none, by
// central differences of the density one voxel to each side; at the domain's faces and beside absent
// values only as far as it reaches. The trilinear field's own gradient jumps from cell to cell. A point in a
// face has neighbours beside its cell, which are stored: those beside the cell across the face may not be.
real3 surface_normal(int3 cell, Ray ray, real t, real isovalue) {
  real3 p = position(ray, t);
  real3 rise = real3(real(0.0));
  real3 reach = real3(real(0.0));
  // No loop of known length, which would be unrolled: llvmpipe executes one turn for other rays.
  int sides = t < NEVER ? 6 : 0;
  for (int i = 0; i < sides; ++i) {
    int3 axis = int3(i < 2 ? 1 : 0, i >> 1 == 1 ? 1 : 0, i > 3 ? 1 : 0);
    int3 side = (i & 1) == 0 ? axis : -axis;
    real3 at = clamp(p + real3(side), real3(density.domain_min), real3(density.domain_max));
    real value = density_at(cell + side, at);
    real3 way = abs(at - p);
    if (absent_voxels && is_nan(value)) {
      value = isovalue;
      way = real3(real(0.0));
    }
    rise = rise + real3(side) * value;
    reach = reach + way;
  }
  reach = max(reach, real3(near_face));
  real3 n = normal_x * (rise.x / reach.x) + normal_y * (rise.y / reach.y) + normal_z * (rise.z / reach.z);
  real size = sqrt(dot(n, n));
  return n * (size > real(0.0) ? real(1.0) / size : real(0.0));
}

// A surface is lit by the scene's lights, or by one from the camera, and from everywhere. It is seen from
// either side, which the value's slope along the ray tells: at a silhouette central differences may lean to
// the other one.
real3 shade(IN(March) m, Ray ray, real t, real isovalue, bool rises) {
  real3 normal = surface_normal(m.cell, ray, t, isovalue) * real(rises ? -1.0 : 1.0);
  real3 light = real3(real(0.0));
  if (surface_lights == 0) light = real3(max(-dot(normal, m.along), real(0.0)));
  for (int i = 0; i < surface_lights; ++i) {
    real4 direction = fetch_table(surface_lights_first + 2 * i);
    real4 shine = fetch_table(surface_lights_first + 2 * i + 1);
    real facing = max(-dot(normal, real3(direction.x, direction.y, direction.z)), real(0.0));
    light = light + real3(shine.x, shine.y, shine.z) * facing;
  }
  return real3(real(0.2)) + light * real(0.8);
}

// The colour of surface k at t, times that of the luminance's grid there.
real3 surface_color(IN(March) m, int k, real t) {
  real4 own = fetch_table(surfaces_first + 2 * k + 1);
  real3 shown = real3(own.x, own.y, own.z);
  if (own_luminance) {
    Track track = Track(m.luminance.ray, seek_node(luminance_grid, m.luminance, t));
    shown = shown * sample_grid(luminance_grid, luminance_source == SOURCE_VECTOR ? 3 : 1, track, t);
  }
  return shown;
}

// The ray meets surface k at t.
void meet_surface(INOUT(March) m, int k, real t, bool rises, Ray ray) {
  real4 own = fetch_table(surfaces_first + 2 * k + 1);
  if (veils && own.w < real(1.0)) {
    real isovalue = fetch_table(surfaces_first + 2 * k).x;
    real3 shown = surface_color(m, k, t) * shade(m, ray, t, isovalue, rises);
    m.radiance = m.radiance + shown * (own.w * m.transmittance);
    m.transmittance *= real(1.0) - own.w;
  } else {
    m.lost = real(rises ? k + 1 : -k - 1);
    m.t = t;
    m.done = true;
  }
  bool half_way = m.done || (veils && -log(m.transmittance) > m.half_at);
  if (half_way && m.shown_at >= NEVER) m.shown_at = t;
}

// Looks for surfaces in a piece of a cell, part by part in which the value is monotone: each value is met
// once at most, in the order of values. f_end is the number that the next cell begins with, so that no
// surface is between the two.
void surface_cell(INOUT(March) m, Node node, INOUT(Stretch) s, Ray ray) {
  Turns turn = turning_points(s.value);
  real3 f = real3(polynomial(s.value, turn.first), polynomial(s.value, turn.second), s.f_end);
  real low = min(min(s.value.f_0, f.x), min(f.y, f.z));
  real high = max(max(s.value.f_0, f.x), max(f.y, f.z));
  bool may_meet = node.kind == NODE_BRICK && m.own && low < last_isovalue && !(high < first_isovalue);
  real t_front = m.t;
  real from = real(0.0);
  real f_from = s.value.f_0;
  int parts = may_meet ? 3 : 0;
  for (int i = 0; i < parts && !m.done; ++i) {
    real to = i == 0 ? turn.first : i == 1 ? turn.second : real(1.0);
    real f_to = i == 0 ? f.x : i == 1 ? f.y : f.z;
    bool rises = f_to > f_from;
    for (int n = 0; n < surfaces && !m.done; ++n) {
      int k = rises ? n : surfaces - 1 - n;
      real isovalue = fetch_table(surfaces_first + 2 * k).x;
      bool met = (f_from < isovalue) != (f_to < isovalue);
      real at = bisect(s.value, isovalue, from, to, met);
      if (met) meet_surface(m, k, t_front + at * s.extent, rises, ray);
    }
    from = to;
    f_from = f_to;
  }
  if (m.done) s.next = m.cell;  // surface_normal looks around it
  else m.t = s.t_end;
  m.front.value = s.f_end;
}

real4 surface_picture(IN(March) m, Ray ray) {
  if (m.lost == real(0.0)) return real4(m.radiance, real(1.0) - m.transmittance);
  int k = int(abs(m.lost)) - 1;
  real isovalue = fetch_table(surfaces_first + 2 * k).x;
  real3 shown = surface_color(m, k, m.t) * shade(m, ray, m.t, isovalue, m.lost > real(0.0));
  return real4(m.radiance + shown * m.transmittance, real(1.0));
}
