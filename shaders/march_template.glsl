// Ray templates (Yagel 1991): under an orthographic camera all rays step through the voxels in the
// same way. A pixel's ray is moved to the nearest voxel of the base plane, the domain's face that
// most faces the camera, and from there takes the one template, a list of voxels (src/march/
// ray_template.h). Samples are voxels' own values, one fetch each; between two of them attenuation
// and luminance are linear.

real component(real3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

// Value of a voxel in a node that covers it.
real voxel_value(int grid, Node node, int3 voxel) {
  if (node.kind == NODE_EMPTY) return real(0.0);
  if (node.kind == NODE_CONSTANT) return fetch_constant(grid, node.payload);
  if (hardware_filter) return sample_scalar(grid, node, real3(voxel));
  int3 local = voxel - node.lo;
  return fetch_texel(grid, node.payload * 729 + (local.x * 9 + local.y) * 9 + local.z);
}

void march_template(INOUT(March) m, Ray ray) {
  Node node = no_node();
  Node domain = Node(0, 0, density_domain_min, density_domain_max);  // the last voxels are not active
  real t_0 = component(face_times(ray, far_faces(ray, density_domain_max, density_domain_min)),
                       template_axis);
  int3 base = int3(floor(position(ray, t_0) + real(0.5)));
  // the same line through that voxel
  real3 shift = real3(base) - position(ray, t_0);
  m.luminance_ray.anchor = m.luminance_ray.anchor + shift;
  // for the walk over nodes, voxel v is the middle of cell v
  Ray moved = ray;
  moved.anchor = ray.anchor + shift + real(0.5);
  moved.offset = -moved.anchor * ray.inverse;

  // Entries are `template_spacing` apart on average, never as much as two of it off.
  if (!m.known) m.lattice = max(m.lattice, int((ray.begin - t_0) / template_spacing) - 4);
  for (int turn = 0; turn < max_turns && !m.done;) {
    for (int n = 0; n < turns_of_product && turn < max_turns && !m.done; ++n, ++turn) {
      int k = m.known ? m.lattice + 1 : m.lattice;
      real4 entry = fetch_table(template_first + k);
      int3 voxel = base + int3(real3(entry));
      real t = t_0 + entry.w;
      bool outside = !inside(domain, voxel);
      if (outside) node = Node(NODE_EMPTY, 1, voxel, voxel + 1);
      else if (!inside(node, voxel)) node = find_node(GRID_DENSITY, voxel);
      m.vacuum = node.kind == NODE_EMPTY;
      real value = voxel_value(GRID_DENSITY, node, voxel);
      seek_gradient(m, voxel);
      Sample s = Sample(value, real(0.0));
      if (with_gradient) s.gradient = voxel_value(GRID_GRADIENT, m.gradient_node, voxel);
      if (count_steps && node.kind == NODE_BRICK) m.samples += 1;
      if (!m.known) {
        m.t = t;
        m.front = with_value(m, m.front, s);
      }
      if (finds_maximum) {
        see_value(m, value, t);
        m.t = t;
        m.front.value = value;
      } else {
        composite_segment(m, s, s, t, t - m.t, false);
      }
      m.known = t >= ray.begin;
      m.lattice = m.known ? k : k + 1;  // in front of the domain: on to the next entry
      // over empty voxels at once, back to a few before their end
      int skip = min(int((leave(moved, node.lo, node.hi).t - t_0) / template_spacing) - 4,
                     template_entries - 2);
      if (m.vacuum && !outside && skip > m.lattice) {
        m.lattice = skip;
        m.t = t_0 + fetch_table(template_first + skip).w;
      }
      end_turn(m, ray);
      if (k >= template_entries - 2) m.done = true;
    }
    refresh_transmittance(m);
  }
}
