// Further volumes, each on a lattice of its own, and their sum along a part of a ray. One grid holds
// the bricks of all. `tables` has OTHER_ENTRIES for each (src/march/others.cpp):
//   0 to 5  rows of the affine map from the density's voxels to its own: numbers, and what float32 left
//   6       first voxel of its page table; levels
//   7       entries of the top table; place of the first one
//   8       first voxel of its domain; channels
//   9       last voxel of its domain
//   10      tau / extinction of value 1; emission of value 1; slots and constants of a channel
//   11      factor of its luminance
//   12      luminance that it has everywhere, less the density's

// All further volumes together, over a part of the ray.
struct Others {
  real end;           // where the first of them leaves a cell
  Cubic attenuation;  // tau / extinction
  Cubics source;      // of each, its tau / extinction times its luminance, a sextic: source(s) +
  Cubics source_high; // s^4 source_high(s). Not a struct: WebGL would not nest so deep
  Cubics glow;        // emission [radiance / unit of t]
};

Cubics no_cubics() { return constant_cubics(real3(real(0.0))); }

Others no_others() {
  Cubics none = no_cubics();
  return Others(NEVER, none.x, none, none, none);
}

Cubics first_part(Cubics c, real part) {
  return Cubics(first_part(c.x, part), first_part(c.y, part), first_part(c.z, part));
}

// Over the first part of what they are given for.
Others first_part(Others o, real part) {
  real squared = part * part;
  Cubics high = scaled(first_part(o.source_high, part), real3(squared * squared));
  return Others(o.end, first_part(o.attenuation, part), first_part(o.source, part), high,
                first_part(o.glow, part));
}

real3 source_at(IN(Others) o, real s) {
  real squared = s * s;
  return polynomials(o.source, s) + polynomials(o.source_high, s) * (squared * squared);
}

// One of them where a ray runs through it.
struct Other {
  Ray ray;
  Node node;
  int3 cell;
  real4 scales;  // entry 10
  int channels;
};

// A row of the affine map, times (p, w).
real mapped(int entry, real3 p, real w) {
  real4 row = fetch_table(entry) + fetch_table(entry + 1);
  return row.x * p.x + row.y * p.y + row.z * p.z + row.w * w;
}

real3 mapped_vector(int first, real3 p, real w) {
  return real3(mapped(first, p, w), mapped(first + 2, p, w), mapped(first + 4, p, w));
}

int3 whole_numbers(real4 v) { return int3(int(v.x), int(v.y), int(v.z)); }

Node find_other(int first, int3 cell) {
  real4 table = fetch_table(first + 6);
  real4 size = fetch_table(first + 7);
  int3 at = cell - whole_numbers(table);
  int shift = 3 * int(table.w);
  int3 q = at >> shift;
  uint entry = fetch_page(others_grid, int(size.w) + (q.x * int(size.y) + q.y) * int(size.z) + q.z);
  for (int level = 1; level < others_levels; ++level) {
    if (int(entry >> PAYLOAD_BITS) == NODE_CHILD) {
      shift -= 3;
      q = (at >> shift) & 7;
      entry = fetch_page(others_grid, (int(entry) & PAYLOAD_MASK) + ((q.x * 8 + q.y) * 8 + q.z));
    }
  }
  return node_of(entry, cell, at, shift);
}

// A channel of it along the ray from t on, over a unit of t.
Cubic other_channel(Other o, real t, int channel) {
  Node node = o.node;
  node.payload += channel * int(node.kind == NODE_BRICK ? o.scales.z : o.scales.w);
  return cubic_along(fetch_corners(others_grid, node, in_brick(o.cell)), position(o.ray, t) - real3(o.cell),
                     o.ray.direction);
}

// Its channels from `first` on: one for all colours, or three.
Cubics other_colors(Other o, real t, int first) {
  Cubic x = other_channel(o, t, first);
  Cubics v = Cubics(x, x, x);
  if (o.channels >= first + 3)
    v = Cubics(x, other_channel(o, t, first + 1), other_channel(o, t, first + 2));
  return v;
}

void add_source(INOUT(Others) sum, Cubic tau, IN(Cubics) L, real3 factor) {
  Cubics low = Cubics(product_low(tau, L.x), product_low(tau, L.y), product_low(tau, L.z));
  Cubics high = Cubics(product_high(tau, L.x), product_high(tau, L.y), product_high(tau, L.z));
  sum.source = sum_of(sum.source, scaled(low, factor));
  sum.source_high = sum_of(sum.source_high, scaled(high, factor));
}

// Adds the light and the attenuation of a volume where it stores values, from t on, over a unit of t.
void add_medium(INOUT(Others) sum, int first, Other o, real t, real phase) {
  Cubic tau = scaled(other_channel(o, t, 0), o.scales.x);
  if (is_nan(tau.f_0 + tau.q_1 + tau.q_2 + tau.q_3)) return;  // an absent corner: the cell is vacuum
  sum.attenuation = sum_of(sum.attenuation, tau);
  if (!others_shine) return;
  real4 lit = fetch_table(first + 11);
  real4 more = fetch_table(first + 12);
  sum.source = sum_of(sum.source, scaled(Cubics(tau, tau, tau), real3(more.x, more.y, more.z)));
  if (o.channels > 1 && o.node.kind == NODE_BRICK)
    add_source(sum, tau, other_colors(o, t, 1), real3(lit.x, lit.y, lit.z) * phase);
}

// Adds the volume that has entries from `first` on, from t on, over a unit of t.
void add_other(INOUT(Others) sum, int first, Ray along, real t, real phase) {
  real4 low = fetch_table(first + 8);
  real4 high = fetch_table(first + 9);
  int3 domain_min = whole_numbers(low);
  int3 domain_max = whole_numbers(high);
  Ray ray = make_ray(mapped_vector(first, along.anchor, real(1.0)),
                     mapped_vector(first, along.direction, real(0.0)), domain_min, domain_max,
                     along.begin);
  real ahead = t + near_face;
  if (ahead < ray.begin && ray.begin < ray.end) sum.end = min(sum.end, ray.begin);
  if (ahead >= ray.begin && ahead < ray.end) {
    int3 cell = clamp(cell_between_faces(ray, ahead, cell_at(ray, ahead, domain_min, domain_max)),
                      domain_min, domain_max - 1);
    Node node = find_other(first, cell);
    bool brick = node.kind == NODE_BRICK;
    sum.end = min(sum.end, next_face_time(ray, brick ? cell : node.lo, brick ? 1 : node.side, ahead));
    if (node.kind != NODE_EMPTY) {
      Other o = Other(ray, node, cell, fetch_table(first + 10), int(low.w));
      if (!(o.scales.y > real(0.0)))
        add_medium(sum, first, o, t, phase);
      else if (others_shine)
        sum.glow = sum_of(sum.glow, scaled(other_colors(o, t, 0), real3(o.scales.y)));
    }
  }
}

// The further volumes from t on, over a unit of t. `phase`: a factor of their light.
Others others_from(Ray ray, real t, real phase) {
  Others sum = no_others();
  for (int i = 0; i < other_volumes; ++i)
    add_other(sum, others_first + i * OTHER_ENTRIES, ray, t, phase);
  return sum;
}
