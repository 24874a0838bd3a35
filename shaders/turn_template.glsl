// Ray templates (Yagel 1991): under an orthographic camera all rays step through the voxels in the
// same way. A pixel's ray is moved to the nearest voxel of the base plane, the domain's face that
// most faces the camera, and from there takes the one template, a list of voxels (src/march/
// march_tables.h). Samples are voxels' own values, one fetch each; between two of them attenuation
// and luminance are linear.

real component(real3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

// Value of a voxel in a node that covers it.
real voxel_value(int grid, Node node, int3 voxel) {
  real v = real(0.0);
  if (node.kind == NODE_CONSTANT) v = fetch_constant(grid, node.payload);
  else if (node.kind == NODE_BRICK && hardware_filter) v = sample_scalar(grid, node, real3(voxel));
  else if (node.kind == NODE_BRICK) v = fetch_texel(grid, texel_index(node.payload, in_brick(voxel)));
  return v;
}

// A walk over the template's voxels.
struct VoxelWalk {
  Node node;    // that holds the last voxel
  int3 base;    // voxel of the base plane
  real t_0;     // where the ray meets that plane
  Ray centred;  // through `base`, shifted by half a voxel: voxel v is the middle of cell v
};

VoxelWalk begin_voxels(INOUT(March) m, Ray ray) {
  real t_0 = component(face_times(ray, far_faces(ray, density.domain_max, density.domain_min)),
                       template_axis);
  real3 start = position(ray, t_0);  // once: the shift is at most half a voxel
  int3 base = int3(floor(start + real(0.5)));
  real3 shift = real3(base) - start;
  m.luminance.ray.anchor = m.luminance.ray.anchor + shift;
  Ray centred = ray;
  centred.anchor = ray.anchor + shift + real(0.5);
  // Entries are `template_spacing` apart on average, and less than two of it off.
  if (!m.known) m.lattice = max(m.lattice, int((ray.begin - t_0) / template_spacing) - 4);
  return VoxelWalk(no_node(), base, t_0, centred);
}

// Skips empty voxels, up to a few before their end.
void skip_voxels(INOUT(March) m, VoxelWalk w) {
  real t_end = leave(w.centred, w.node.lo, w.node.side).t;
  int last = min(int((t_end - w.t_0) / template_spacing) - 4, template_entries - 2);
  if (last <= m.lattice) return;
  m.lattice = last;
  m.t = w.t_0 + fetch_table(template_first + last).w;
}

void turn_template(INOUT(March) m, INOUT(VoxelWalk) w, Ray ray) {
  int k = m.known ? m.lattice + 1 : m.lattice;
  real4 entry = fetch_table(template_first + k);
  int3 voxel = w.base + int3(real3(entry));
  real t = w.t_0 + entry.w;
  // the last voxels are not active
  bool outside = !inside_box(density.domain_min, density.domain_max, voxel);
  if (outside) w.node = empty_node(voxel, 1);
  else if (!inside(w.node, voxel)) w.node = find_node(density_grid, voxel);
  real value = voxel_value(density_grid, w.node, voxel);
  if (absent_voxels && is_nan(value)) {
    w.node = absent_node(voxel, 1);
    value = node_value(w.node);
  }
  m.vacuum = w.node.kind == NODE_EMPTY;
  seek_gradient(m, voxel);
  Sample s = Sample(value, real(0.0));
  if (with_gradient) s.gradient = voxel_value(gradient_grid, m.gradient.node, voxel);
  m.samples += look_ups(w.node);
  if (!m.known) {
    m.t = t;
    m.front = with_value(m, m.front, s);
  }
  cross_step(m, s, s, t, false);
  m.known = t >= ray.begin;
  m.lattice = m.known ? k : k + 1;  // in front of the domain: on to the next entry
  if (m.vacuum && !outside) skip_voxels(m, w);
  if (k >= template_entries - 2) m.done = true;
}
