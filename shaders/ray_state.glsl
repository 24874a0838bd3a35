// What a ray carries, and what it reads of the medium.
const real UNKNOWN = real(-8.507059173023462e37);  // -2^126: equal in float32 and double
const real LN2 = real(0.6931471805599453);

// The medium at a point of the ray.
struct Point {
  real value;        // of the density grid
  real attenuation;  // of it, without `extinction`
  real3 L;           // luminance, without `color` and `tint`; only x where it is scalar
  real3 tint;        // lit_colors: the function's, a factor of L
  real3 glow;        // emission [radiance / unit of t]
  real slope;        // of the attenuation along the ray [1 / unit of t]; these two only with
  real3 L_slope;     // end_corrections
};

#include "track.glsl"
#include "emission.glsl"

// All that a ray carries from turn to turn, and from pass to pass.
struct March {
  real t;              // how far the ray is integrated
  Point front;         // the medium at t
  int3 cell;           // the next cell to look up in the density grid
  int lattice;         // template: the voxel that t is at
  bool known;          // `front` is the medium at t; if not, a turn of length 0 finds it
  bool vacuum;         // what the turn looks at is an empty run
  bool own;            // and it begins in the region that the ray collects from
  int interval;        // of the transfer function, where pieces end at its knots
  real phase;          // factor of all luminance along the ray
  real3 along;         // direction of the ray in the world, for surfaces; a pass does not keep it
  real3 radiance;      // without `color`, unless there is emission; of a value see modes/value.glsl
  real3 radiance_lost; // what rounding left out of it (Kahan); a pass does not keep it
  real optical_depth;
  real lost;           // what rounding left out of optical_depth (Kahan); or an opaque surface
  real transmittance;  // e^{-optical_depth}, kept only where the radiance needs it; or of surfaces
  real half_at;        // optical depth at which the transmittance falls below 1/2
  real stop_at;        // optical depth at which the ray ends
  real shown_at;       // t at which the transmittance falls below 1/2, or of the maximum, the surface
  real step_error;     // h^2/12 of the segment before t, see correct_step
  int steps;
  int samples;
  bool done;
  bool stuck;          // it no longer advanced and was ended early
  Track luminance;
  Emission emission;
  Track gradient;      // its ray is the density's and is not used
  Pairs pairs;         // paired: corners of the cell that the turn reads, whose first voxel is
  real3 pairs_at;      // this; they hold only where
  bool paired_here;    // this is set, else the turn reads no brick
  bool paired_front;   // the front's luminance is one of a brick
  Others others;       // further volumes along the piece that the turn crosses
};

#include "march_derived.glsl"

March begin_march(Ray ray) {
  March m;
  m.phase = real(1.0);
  m.along = real3(real(0.0));
  m.t = ray.begin;
  m.front = Point(UNKNOWN, real(0.0), real3(real(1.0)), real3(real(1.0)), real3(real(0.0)),
                  real(0.0), real3(real(0.0)));
  m.step_error = real(0.0);
  m.cell = cell_at(ray, ray.begin, density.domain_min, density.domain_max);
  m.lattice = 0;
  m.known = false;
  m.vacuum = false;
  m.own = true;
  m.interval = 0;
  m.radiance = real3(real(0.0));
  if (shows == SHOWS_value && mode != MODE_mean) m.radiance.x = UNKNOWN;
  m.radiance_lost = real3(real(0.0));
  m.optical_depth = real(0.0);
  m.lost = real(0.0);
  m.transmittance = real(1.0);
  m.half_at = LN2;
  m.stop_at = stop_depth;
  m.shown_at = NEVER;
  m.steps = 0;
  m.samples = 0;
  m.stuck = false;
  m.done = !(ray.end > ray.begin);
  m.luminance = Track(ray, no_node());
  m.gradient = m.luminance;
  real4 dark = real4(real(0.0));
  m.pairs = Pairs(dark, dark, dark, dark, dark, dark, dark, dark, real2(real(0.0)), real2(real(0.0)));
  m.pairs_at = real3(real(0.0));
  m.paired_here = false;
  m.paired_front = false;
  if (other_volumes > 0) m.others = no_others();
  return m;
}

// The phase, the rays in the other grids, and what was passed, which no pass keeps.
void aim(INOUT(March) m, Pixel p) {
  m.phase = phase_of(p);
  if (shows == SHOWS_surface) m.along = (world_0 + world_u * p.u + world_v * p.v) * p.inverse_length;
  if (has_passed) {
    // before its region: the greatest value, or the optical depth
    real passed = table_number(passed_first, p.number);
    if (shows == SHOWS_value) {
      if (mode != MODE_mean) m.radiance.x = max(m.radiance.x, passed);
    } else {
      m.half_at -= passed;
      m.stop_at -= passed;
      if (passed > stop_depth) m.done = true;
    }
  }
  if (own_luminance) m.luminance = track_of(p, luminance);
  if (has_emission) aim_emission(m.emission, p);
}

// Runs of one value that need no samples, where all else is constant along them too; and empty ones.
bool constant_run(Node node) {
  return constant_runs && node.kind == NODE_CONSTANT && !with_gradient && !has_emission
         && (!own_luminance || (beside_density && other_volumes > 0));
}
bool closed_form(Node node) { return node.kind == NODE_EMPTY || constant_run(node); }

// Whether the walk is beyond the density for the sake of another grid. There is no medium, whatever
// the function gives for 0.
bool beyond_density(int3 cell) {
  return beyond && !inside_box(density_field_min, density_field_max, cell);
}

real node_value(Node node) {
  if (shows == SHOWS_value && is_absent(node)) return UNKNOWN;  // no maximum is below it
  return constant_runs && node.kind == NODE_CONSTANT ? fetch_constant(density_grid, node.payload)
                                                     : real(0.0);
}

// Moves the gradient's node to a cell of the density's.
void seek_gradient(INOUT(March) m, int3 cell) {
  if (!with_gradient) return;
  m.gradient.node = seek_cell(gradient_grid, cell, m.gradient.node, density_field_min,
                              density_field_max);
  m.samples += look_ups(m.gradient.node);
}

// Moves the nodes of separate grids to t, of the luminance only where it counts; point_at(t) follows.
void seek(INOUT(March) m, real t, bool luminous) {
  if (tracks_luminance && luminous) {
    m.luminance.node = seek_node(luminance_grid, m.luminance, t);
    m.samples += look_ups(m.luminance.node);
  }
  if (has_emission) m.samples += seek_emission(m.emission, t);
}

real3 sample_luminance(IN(March) m, real t) {
  return sample_grid(luminance_grid, luminance_source == SOURCE_VECTOR ? 3 : 1, m.luminance, t);
}

// Reads the corners of a cell of a brick for the turn's look-ups.
void read_pairs(INOUT(March) m, Node brick, int3 cell) {
  if (!hardware_filter) m.pairs = fetch_pairs(brick, in_brick(cell));
  m.pairs_at = real3(cell);
  m.luminance.node = brick;
  m.paired_here = true;
}

// The luminance beside the density at t. Where nothing is stored nothing attenuates, and it is as in
// front: a segment that begins or ends there takes the luminance of its other end.
real3 paired_luminance(IN(March) m, real t) {
  real3 L = m.front.L;
  if (m.paired_here) {
    if (hardware_filter) {
      L = sample_luminance(m, t);
    } else {
      real4 v = trilinear_pairs(m.pairs, position(m.luminance.ray, t) - m.pairs_at);
      L = luminance_source == SOURCE_VECTOR ? real3(v.y, v.z, v.w) : real3(v.y);
    }
  }
  return L;
}

// Its slope along the ray.
real3 paired_slope(IN(March) m, real t) {
  real3 slope = real3(real(0.0));
  if (m.paired_here) {
    real3 along = m.luminance.ray.direction;
    real3 u = position(m.luminance.ray, t) - m.pairs_at;
    slope = real3(dot(trilinear_gradient(luminances_x(m.pairs), u), along));
    if (luminance_source == SOURCE_VECTOR) {
      slope.y = dot(trilinear_gradient(luminances_y(m.pairs), u), along);
      slope.z = dot(trilinear_gradient(luminances_z(m.pairs), u), along);
    }
  }
  return slope;
}

Classified classify_at(IN(March) m, Sample s) {
  if (keeps_interval) return classify_within(m.interval, s.value);
  return classify(s);
}

real attenuation_of(IN(March) m, Sample s) {
  return transfer ? classify_at(m, s).attenuation : s.value;
}

// The point with another value of the density grid.
Point with_value(IN(March) m, IN(Point) p, Sample s) {
  Classified c = Classified(s.value, real3(real(1.0)));
  if (transfer) c = classify_at(m, s);
  real attenuation = vacuum_differs && m.vacuum ? real(0.0) : c.attenuation;
  real3 L = p.L;
  if (luminance_source == SOURCE_DENSITY) L = real3(s.value, s.value, s.value);
  if (luminance_source == SOURCE_TRANSFER) L = c.color;
  return Point(s.value, attenuation, L, c.color, p.glow, p.slope, p.L_slope);
}

// The luminance at a point, without `color`.
real3 luminance_of(IN(Point) p) {
  if (lit_colors) return p.L * p.tint;
  return p.L;
}

// Emission in a region's empty runs belongs to another region, which walks it. Steps may end in one.
bool glows(IN(March) m) {
  return has_emission && (uniform_sampling ? m.own : !(in_part && m.vacuum));
}

// The medium at t, where the density grid has `s`; seek(t, luminous) has found the other grids' nodes.
Point point_at(IN(March) m, real t, Sample s, bool luminous) {
  real3 none = real3(real(0.0));
  Point p = Point(s.value, s.value, real3(real(1.0)), none, none, real(0.0), none);
  if (beside_density && luminous) p.L = paired_luminance(m, t);
  if (tracks_luminance && luminous)
    p.L = sample_luminance(m, t);
  if (has_emission) p.glow = emission_at(m.emission, t);
  return with_value(m, p, s);
}

