// What a ray carries, and what it reads of the medium.
const int MODE_ALPHA = 0;  // Mode
const int MODE_BACK_TO_FRONT = 1;
const int MODE_MIP = 2;
const int MODE_LMIP = 3;
const int MODE_ISOSURFACE = 4;
const int MODE_XRAY = 5;

const real NEVER = real(1e30);
const real UNKNOWN = real(-1e38);
const real LN2 = real(0.6931471805599453);

// The medium at a point of the ray.
struct Point {
  real value;        // of the density grid
  real attenuation;  // of it, without `extinction`
  real3 L;           // luminance, without `color`; only x where it is scalar
  real3 glow;        // emission [radiance / unit of t]
  real slope;        // of the attenuation along the ray [1 / unit of t]; these two only with
  real3 L_slope;     // end_corrections
};

// All that a ray carries from turn to turn, and from pass to pass.
struct March {
  real t;              // how far the ray is integrated
  Point front;         // the medium at t
  int3 cell;           // the next cell to look up in the density grid
  int lattice;         // template: the voxel that t is at
  bool known;          // `front` is that of t; if not, a turn of length 0 finds it
  bool vacuum;         // what the turn looks at is an empty run
  int interval;        // of the transfer function, where pieces end at its knots
  real phase;          // factor of all luminance along the ray
  real3 radiance;      // without `color`, unless there is emission; of maxima x is the value
  real optical_depth;
  real lost;           // what rounding left out of optical_depth (Kahan)
  real transmittance;  // e^{-optical_depth}; kept only where the radiance needs it
  real half_depth;     // t at which the transmittance falls below 1/2, or of the maximum, the surface
  real step_error;     // h^2/12 of the segment before t, see correct_step
  int steps;
  int samples;
  int turns;
  bool done;
  Ray luminance_ray;   // of a separate luminance grid, and the node that was read last
  Node luminance_node;
  Ray emission_ray;    // the same of an emission grid
  Node emission_node;
  Node gradient_node;  // the same of the gradient's, whose ray is the density's
};

#include "march_derived.glsl"

March begin_march(Ray ray) {
  March m;
  m.phase = real(1.0);
  m.t = ray.begin;
  m.front = Point(UNKNOWN, real(0.0), real3(real(1.0)), real3(real(0.0)), real(0.0), real3(real(0.0)));
  m.step_error = real(0.0);
  m.cell = cell_at(ray, ray.begin, density_domain_min, density_domain_max);
  m.lattice = 0;
  m.known = false;
  m.vacuum = false;
  m.interval = 0;
  m.radiance = real3(finds_maximum ? UNKNOWN : real(0.0));
  m.optical_depth = real(0.0);
  m.lost = real(0.0);
  m.transmittance = real(1.0);
  m.half_depth = NEVER;
  m.steps = 0;
  m.samples = 0;
  m.turns = 0;
  m.done = !(ray.end > ray.begin);
  m.luminance_node = no_node();
  m.luminance_ray = ray;
  m.emission_node = no_node();
  m.emission_ray = ray;
  m.gradient_node = no_node();
  return m;
}

// Runs of one value that need no samples, where all else is constant along them too; and empty ones.
bool constant_run(Node node) {
  return constant_runs && node.kind == NODE_CONSTANT && !with_gradient && !own_luminance
         && !has_emission;
}
bool closed_form(Node node) { return node.kind == NODE_EMPTY || constant_run(node); }

// Where the walk goes on for the sake of another grid: no medium, whatever 0 means.
bool beyond_density(int3 cell) {
  return beyond && !inside(Node(0, 0, density_field_min, density_field_max), cell);
}

real node_value(Node node) {
  return constant_runs && node.kind == NODE_CONSTANT ? fetch_constant(GRID_DENSITY, node.payload)
                                                     : real(0.0);
}

// Node of another grid's that covers a cell.
Node seek_cell(int grid, int3 cell, Node node, int3 domain_min, int3 domain_max) {
  if (inside(node, cell)) return node;
  if (inside(Node(0, 0, domain_min, domain_max), cell)) return find_node(grid, cell);
  return Node(NODE_EMPTY, 1, cell, cell + 1);
}

// The same at t.
Node seek_node(int grid, Ray ray, Node node, int3 domain_min, int3 domain_max, real t) {
  return seek_cell(grid, int3(floor(position(ray, t))), node, domain_min, domain_max);
}

// Moves the gradient's node to a cell of the density's.
void seek_gradient(INOUT(March) m, int3 cell) {
  if (!with_gradient) return;
  m.gradient_node = seek_cell(GRID_GRADIENT, cell, m.gradient_node, density_field_min,
                              density_field_max);
  if (count_steps && m.gradient_node.kind == NODE_BRICK) m.samples += 1;
}

// Moves the nodes of separate grids to t; point_at(t) follows.
void seek(INOUT(March) m, real t) {
  if (own_luminance) {
    m.luminance_node = seek_node(GRID_LUMINANCE, m.luminance_ray, m.luminance_node,
                                 luminance_domain_min, luminance_domain_max, t);
    if (count_steps && m.luminance_node.kind == NODE_BRICK) m.samples += 1;
  }
  if (has_emission) {
    m.emission_node = seek_node(GRID_EMISSION, m.emission_ray, m.emission_node,
                                emission_domain_min, emission_domain_max, t);
    if (count_steps && m.emission_node.kind == NODE_BRICK) m.samples += 1;
  }
}

real3 sample_grid(int grid, int channels, Node node, Ray ray, real t) {
  if (node.kind == NODE_EMPTY) return real3(real(0.0));
  if (channels == 3) return sample_vector(grid, node, position(ray, t));
  real v = sample_scalar(grid, node, position(ray, t));
  return real3(v, v, v);
}

Classified classify_at(IN(March) m, Sample s) {
  if (keeps_interval) return classify_within(m.interval, s.value);
  return classify(s);
}

real attenuation_of(IN(March) m, Sample s) {
  return transfer ? classify_at(m, s).attenuation : s.value;
}

// The same point with another value of the density grid.
Point with_value(IN(March) m, Point p, Sample s) {
  real value = s.value;
  Classified c = Classified(value, real3(real(1.0)));
  if (transfer) c = classify_at(m, s);
  p.value = value;
  p.attenuation = m.vacuum ? real(0.0) : c.attenuation;
  if (luminance_source == SOURCE_DENSITY) p.L = real3(value, value, value);
  if (luminance_source == SOURCE_TRANSFER) p.L = c.color;
  return p;
}

// The medium at t, where the density grid has `s`; other grids' nodes are there already.
Point point_at(IN(March) m, real t, Sample s) {
  real3 none = real3(real(0.0));
  Point p = Point(s.value, s.value, real3(real(1.0)), none, real(0.0), none);
  if (own_luminance)
    p.L = sample_grid(GRID_LUMINANCE, luminance_source == SOURCE_VECTOR ? 3 : 1, m.luminance_node,
                      m.luminance_ray, t);
  if (has_emission)
    p.glow = sample_grid(GRID_EMISSION, emission_channels, m.emission_node, m.emission_ray, t)
           * emission_scale;
  return with_value(m, p, s);
}

