// The first surface of a value, shaded.

// Looks for the surface in a piece of a cell.
void surface_cell(INOUT(March) m, Node node, INOUT(Stretch) s) {
  real at = first_crossing(s.value, isovalue, s.f_end);
  if (node.kind == NODE_BRICK && at <= real(1.0) && m.own) {
    m.half_depth = m.t + at * s.extent;
    m.radiance.x = real(s.value.f_0 < isovalue ? 1.0 : -1.0);
    m.done = true;
    s.next = m.cell;  // surface_normal looks around it
  }
  m.t = s.t_end;
  m.front.value = s.f_end;
}

// The density at a point of a cell; NaN where it is absent.
real density_at(int3 cell, real3 p) {
  int3 near = clamp(cell, density.domain_min, density.domain_max - 1);
  Node node = sampled_node(find_stored(density_grid, near), near);
  if (is_absent(node)) return real_of_bits(0x7fc00000u);
  return node.kind == NODE_EMPTY ? real(0.0) : sample_scalar(density_grid, node, p);
}

// Where the ray hits a surface, in a cell: its normal in the world, 0 where the field has none, by
// central differences of the density one voxel to each side; at the domain's faces and beside absent
// values only as far as it reaches. The trilinear field's own gradient jumps from cell to cell. A point in a face has neighbours
// beside its cell, which are stored: those beside the cell across the face may not be.
real3 surface_normal(int3 cell, Ray ray, real t) {
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

// A surface is lit by the scene's lights, or by one from the camera, and from everywhere.
real3 shade(IN(March) m, Ray ray, Pixel p) {
  real3 w = (world_0 + world_u * p.u + world_v * p.v) * p.inverse_length;
  // Seen from either side, which the value's slope along the ray tells: at a silhouette central
  // differences may lean to the other one.
  real3 normal = surface_normal(m.cell, ray, m.half_depth) * -m.radiance.x;
  real3 light = real3(real(0.0));
  if (surface_lights == 0) light = real3(max(-dot(normal, w), real(0.0)));
  for (int i = 0; i < surface_lights; ++i) {
    real4 direction = fetch_table(surface_lights_first + 2 * i);
    real4 shine = fetch_table(surface_lights_first + 2 * i + 1);
    real facing = max(-dot(normal, real3(direction.x, direction.y, direction.z)), real(0.0));
    light = light + real3(shine.x, shine.y, shine.z) * facing;
  }
  return real3(real(0.2)) + light * real(0.8);
}

// The colour where the ray hits the surface: of the isovalue, or of the luminance's grid there.
real3 surface_color(IN(March) m) {
  real3 shown = color;
  if (luminance_source == SOURCE_TRANSFER) shown = color * classify(isovalue).color;
  if (own_luminance) {
    Track track = Track(m.luminance.ray, seek_node(luminance_grid, m.luminance, m.half_depth));
    shown = color * sample_grid(luminance_grid, luminance_source == SOURCE_VECTOR ? 3 : 1, track, m.half_depth);
  }
  return shown;
}

real4 surface_picture(IN(March) m, Ray ray, Pixel p) {
  if (m.half_depth >= NEVER) return real4(real(0.0));
  real3 shown = surface_color(m);
  return real4(shown * shade(m, ray, p), real(1.0));
}
