// Light on a lattice that is sheared along it: columns run along the light through the density's
// voxels and are recorded where they cross the slices of voxels of one axis, so that a voxel's depth is
// interpolated across columns only (after the slices of Lacroute and Levoy 1994). A column's t counts
// slices from the light's side on. See src/march/light_lattice.h.

// What a column meets at a point.
struct LatticePoint {
  real value;
  real attenuation;  // without `extinction`
  bool vacuum;       // nothing is stored there: the value is not known, its attenuation is 0
};

struct Column {
  Ray ray;
  Node node;           // that were read last
  Node gradient_node;
  LatticePoint front;  // at t
  real t;
  real depth;          // optical depth from the first slice asked for to t
};

Node column_node(int grid, Node node, int3 cell) {
  if (inside(node, cell)) return node;
  return find_stored(grid, cell);
}

LatticePoint column_point(INOUT(Column) c, real t) {
  real3 p = position(c.ray, t);
  int3 cell = clamp(int3(floor(p)), density.domain_min, density.domain_max - 1);
  c.node = column_node(density_grid, c.node, cell);
  LatticePoint point = LatticePoint(real(0.0), real(0.0), c.node.kind == NODE_EMPTY);
  if (point.vacuum) return point;
  point.value = sample_scalar(density_grid, c.node, p);
  point.attenuation = point.value;
  if (transfer) {
    real slope = real(0.0);
    if (with_gradient) {
      c.gradient_node = column_node(gradient_grid, c.gradient_node, cell);
      if (c.gradient_node.kind != NODE_EMPTY)
        slope = sample_scalar(gradient_grid, c.gradient_node, p);
    }
    point.attenuation = classify(Sample(point.value, slope)).attenuation;
  }
  return point;
}

// Mean attenuation between two points by a function of the value: exact where the value is linear.
real function_mean(LatticePoint a, LatticePoint b) {
  if (a.vacuum || b.vacuum) return real(0.5) * (a.attenuation + b.attenuation);
  if (ramps) return ramp_mean(a.value, b.value);
  return transfer_average(a.value, b.value).attenuation;
}

// Goes on to t: Simpson's rule, or the function's integrals on both halves.
void extend_column(INOUT(Column) c, real t) {
  LatticePoint front = c.front;
  LatticePoint middle = column_point(c, real(0.5) * (c.t + t));
  LatticePoint back = column_point(c, t);
  real mean = (front.attenuation + real(4.0) * middle.attenuation + back.attenuation) / real(6.0);
  if (transfer && !with_gradient)
    mean = real(0.5) * (function_mean(front, middle) + function_mean(middle, back));
  c.depth += extinction * lattice_length * (t - c.t) * mean;
  c.front = back;
  c.t = t;
}

// Optical depths along a column from the slice before `first` to `first` and the seven behind it.
struct ColumnDepths {
  real4 first;
  real4 last;
};

// `column`: numbers of the column along both axes; a slice's is a whole number too.
ColumnDepths column_depths(real2 column, real first) {
  Column c;
  // a function may attenuate up to the faces of its own grid's domain
  c.ray = make_ray(lattice_anchor + lattice_u * column.x + lattice_v * column.y, lattice_step,
                   transfer ? density_field_min : density.domain_min,
                   transfer ? density_field_max : density.domain_max, real(-1e30));
  c.node = no_node();
  c.gradient_node = no_node();
  c.depth = real(0.0);
  c.t = max(first - real(1.0), c.ray.begin);
  c.front = LatticePoint(real(0.0), real(0.0), true);
  ColumnDepths depths = ColumnDepths(real4(real(0.0)), real4(real(0.0)));
  if (c.t < min(first + real(7.0), c.ray.end)) c.front = column_point(c, c.t);
  for (int n = 0; n < 8; ++n) {
    for (int part = lattice_parts - 1; part >= 0; --part) {
      real t = min(first + real(n) - real(part) / real(lattice_parts), c.ray.end);
      if (t > c.t) extend_column(c, t);
    }
    if (n < 4) depths.first[n] = c.depth;
    else depths.last[n - 4] = c.depth;
  }
  return depths;
}
