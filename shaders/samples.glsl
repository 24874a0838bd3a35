// Values of a grid: in a cell, at a point of a node, and along a ray.

// The 8 corner values of a cell: lo.x = v(0,0,0), lo.y = v(0,0,1), lo.z = v(0,1,0),
// lo.w = v(0,1,1); hi the same at x + 1.
// Where `coded` they are codes, whose values are from + scale * code. What the march makes of corners is
// linear in them: it is made of the codes, and `decoded` turns the result into values.
struct Corners {
  real4 lo;
  real4 hi;
  real scale;
  real from;
};

Corners plain_corners(real4 lo, real4 hi) { return Corners(lo, hi, real(1.0), real(0.0)); }

// From codes to values: a difference of two, one, a polynomial.
real decoded_difference(Corners c, real d) {
  if (coded) return c.scale * d;
  return d;
}
real decoded(Corners c, real x) {
  if (coded) return c.from + c.scale * x;
  return x;
}
Cubic decoded(Corners c, Cubic x) {
  if (!coded) return x;
  x = scaled(x, c.scale);
  return Cubic(c.from + x.f_0, x.q_1, x.q_2, x.q_3);
}

// The values at a texel and at its neighbours along y and z.
real4 fetch_four(int grid, int i) {
  return real4(fetch_texel(grid, i), fetch_texel(grid, i + NEXT_Z), fetch_texel(grid, i + NEXT_Y),
               fetch_texel(grid, i + NEXT_Y + NEXT_Z));
}

// Whether a cell of the grid has one value, that of the voxel at its first corner. The ray then runs
// half a voxel beside the grid, so that each voxel is the middle of its cell.
bool by_voxel(int grid) {
  return nearest && (grid == density_grid || grid == gradient_grid || (lit_voxels && grid == luminance_grid));
}

#include "codes.glsl"

// Of a node's cell, given from its brick's first one.
Corners fetch_corners(int grid, Node node, int3 cell) {
  Corners c;
  if (node.kind == NODE_CONSTANT) {
    real4 v = real4(fetch_constant(grid, node.payload));
    c = plain_corners(v, v);
  } else if (coded && paired && grid == luminance_grid) {
    c = decode_brick(node, cell).x;
  } else if (coded && grid == density_grid) {
    c = decode_brick(node, cell).v;
  } else if (by_voxel(grid)) {
    real4 v = real4(fetch_texel(grid, texel_index(node.payload, cell)));
    c = plain_corners(v, v);
  } else {
    int i = texel_index(node.payload, cell);
    c = plain_corners(fetch_four(grid, i), fetch_four(grid, i + NEXT_X));
  }
  return c;
}

// Trilinear interpolation, u in [0,1]^3 inside the cell.
real trilinear(Corners c, real3 u) {
  real4 x = c.lo + (c.hi - c.lo) * u.x;
  real y0 = x.x + (x.z - x.x) * u.y;
  real y1 = x.y + (x.w - x.y) * u.y;
  return decoded(c, y0 + (y1 - y0) * u.z);
}

// The 8 corners of a cell of a brick, by their place along x, y and z: the density, and a luminance of
// up to three channels beside it, which share a code.
struct Pairs {
  real4 v_000;
  real4 v_001;
  real4 v_010;
  real4 v_011;
  real4 v_100;
  real4 v_101;
  real4 v_110;
  real4 v_111;
  real2 scale;  // as in Corners: of the density, of the luminance
  real2 from;
};

// Of a brick's cell, given from its first one.
Pairs fetch_pairs(Node brick, int3 cell) {
  if (coded) {
    CodedBrick b = decode_brick(brick, cell);
    return Pairs(real4(b.v.lo.x, b.x.lo.x, b.y.lo.x, b.z.lo.x),
                 real4(b.v.lo.y, b.x.lo.y, b.y.lo.y, b.z.lo.y),
                 real4(b.v.lo.z, b.x.lo.z, b.y.lo.z, b.z.lo.z),
                 real4(b.v.lo.w, b.x.lo.w, b.y.lo.w, b.z.lo.w),
                 real4(b.v.hi.x, b.x.hi.x, b.y.hi.x, b.z.hi.x),
                 real4(b.v.hi.y, b.x.hi.y, b.y.hi.y, b.z.hi.y),
                 real4(b.v.hi.z, b.x.hi.z, b.y.hi.z, b.z.hi.z),
                 real4(b.v.hi.w, b.x.hi.w, b.y.hi.w, b.z.hi.w), real2(b.v.scale, b.x.scale),
                 real2(b.v.from, b.x.from));
  }
  int i = texel_index(brick.payload, cell);
  if (nearest) {
    real4 v = fetch_pair(i);
    return Pairs(v, v, v, v, v, v, v, v, real2(real(1.0), real(1.0)), real2(real(0.0), real(0.0)));
  }
  int k = i + NEXT_X;
  return Pairs(fetch_pair(i), fetch_pair(i + NEXT_Z), fetch_pair(i + NEXT_Y),
               fetch_pair(i + NEXT_Y + NEXT_Z), fetch_pair(k), fetch_pair(k + NEXT_Z),
               fetch_pair(k + NEXT_Y), fetch_pair(k + NEXT_Y + NEXT_Z), real2(real(1.0), real(1.0)),
               real2(real(0.0), real(0.0)));
}

Corners densities(IN(Pairs) p) {
  return Corners(real4(p.v_000.x, p.v_001.x, p.v_010.x, p.v_011.x),
                 real4(p.v_100.x, p.v_101.x, p.v_110.x, p.v_111.x), p.scale.x, p.from.x);
}

// The luminance: its first, second and third channel.
Corners luminances_x(IN(Pairs) p) {
  return Corners(real4(p.v_000.y, p.v_001.y, p.v_010.y, p.v_011.y),
                 real4(p.v_100.y, p.v_101.y, p.v_110.y, p.v_111.y), p.scale.y, p.from.y);
}

Corners luminances_y(IN(Pairs) p) {
  return Corners(real4(p.v_000.z, p.v_001.z, p.v_010.z, p.v_011.z),
                 real4(p.v_100.z, p.v_101.z, p.v_110.z, p.v_111.z), p.scale.y, p.from.y);
}

Corners luminances_z(IN(Pairs) p) {
  return Corners(real4(p.v_000.w, p.v_001.w, p.v_010.w, p.v_011.w),
                 real4(p.v_100.w, p.v_101.w, p.v_110.w, p.v_111.w), p.scale.y, p.from.y);
}

real4 trilinear_pairs(IN(Pairs) p, real3 u) {
  real4 v_00 = mix(p.v_000, p.v_100, u.x);
  real4 v_01 = mix(p.v_001, p.v_101, u.x);
  real4 v_10 = mix(p.v_010, p.v_110, u.x);
  real4 v_11 = mix(p.v_011, p.v_111, u.x);
  real4 v = mix(mix(v_00, v_10, u.y), mix(v_01, v_11, u.y), u.z);
  if (coded)
    return real4(p.from.x, p.from.y, p.from.y, p.from.y) + v * real4(p.scale.x, p.scale.y, p.scale.y, p.scale.y);
  return v;
}

// Coefficient of u.x u.y u.z in the trilinear polynomial.
real third_difference(Corners c) {
  real4 d = c.hi - c.lo;
  return decoded_difference(c, (d.w - d.z) - (d.y - d.x));
}

// The polynomial along u + d s, s in [0, 1]: a cubic, whose coefficients follow axis by axis.
Cubic cubic_along(Corners c, real3 u, real3 d) {
  real4 dx = c.hi - c.lo;
  real4 a = c.lo + dx * u.x;  // four edges along x: a + b s
  real4 b = dx * d.x;
  real2 da = real2(a.z - a.x, a.w - a.y);
  real2 db = real2(b.z - b.x, b.w - b.y);
  real2 y_0 = real2(a.x, a.y) + da * u.y;  // two lines along y: of second degree
  real2 y_1 = real2(b.x, b.y) + db * u.y + da * d.y;
  real2 y_2 = db * d.y;
  real3 e = real3(y_0.y - y_0.x, y_1.y - y_1.x, y_2.y - y_2.x);
  return decoded(c, Cubic(y_0.x + e.x * u.z, y_1.x + e.y * u.z + e.x * d.z,
                          y_2.x + e.z * u.z + e.y * d.z, e.z * d.z));
}

// Up to three channels along a part of a ray: a cubic each.
struct Cubics {
  Cubic x;
  Cubic y;
  Cubic z;
};

real3 polynomials(IN(Cubics) c, real s) {
  return real3(polynomial(c.x, s), polynomial(c.y, s), polynomial(c.z, s));
}

Cubics constant_cubics(real3 v) {
  real none = real(0.0);
  return Cubics(Cubic(v.x, none, none, none), Cubic(v.y, none, none, none), Cubic(v.z, none, none, none));
}

Cubics scaled(Cubics c, real3 factors) {
  return Cubics(scaled(c.x, factors.x), scaled(c.y, factors.y), scaled(c.z, factors.z));
}

Cubics sum_of(Cubics a, Cubics b) {
  return Cubics(sum_of(a.x, b.x), sum_of(a.y, b.y), sum_of(a.z, b.z));
}

// Through the values at 0, 1/2 and 1.
Cubics parabolas(real3 f_0, real3 f_half, real3 f_1) {
  real none = real(0.0);
  return Cubics(make_cubic(f_0.x, f_half.x, f_1.x, none), make_cubic(f_0.y, f_half.y, f_1.y, none),
                make_cubic(f_0.z, f_half.z, f_1.z, none));
}

// No corner is greater, nor any sum that makes one from its code.
real greatest_magnitude(Corners c) {
  real4 m = max(abs(c.lo), abs(c.hi));
  real most = max(max(m.x, m.y), max(m.z, m.w));
  if (coded) return abs(c.from) + c.scale * most;
  return most;
}

// Gradient of the trilinear polynomial over voxels.
real3 trilinear_gradient(Corners c, real3 u) {
  real4 dx = c.hi - c.lo;
  real4 x = c.lo + dx * u.x;
  real dy0 = x.z - x.x;
  real dy1 = x.w - x.y;
  real gx0 = dx.x + (dx.z - dx.x) * u.y;
  real gx1 = dx.y + (dx.w - dx.y) * u.y;
  real3 g = real3(gx0 + (gx1 - gx0) * u.z, dy0 + (dy1 - dy0) * u.z,
                  (x.y - x.x) + ((x.w - x.z) - (x.y - x.x)) * u.y);
  if (coded) return g * c.scale;
  return g;
}

// Where a position lies in its brick: cells are clamped, since a position on a face may round into
// the neighbour.
int3 local_cell(real3 local) { return clamp(int3(floor(local)), int3(0), int3(BRICK_CELLS - 1)); }

// The same in a node that may be a single cell, beside which values may be absent.
int3 local_cell(Node node, real3 local) {
  int3 cell = local_cell(local);
  if (absent_voxels) {
    int3 lo = in_brick(node.lo);
    cell = clamp(cell, lo, lo + (node.side - 1));
  }
  return cell;
}

// Whether a cell of the density's brick has an absent corner: NaN, or the greatest of its codes.
bool lacks_corner(Node brick, int3 cell) {
  Corners c = fetch_corners(density_grid, brick, in_brick(cell));
  if (coded) {
    real4 most = max(c.lo, c.hi);
    uint width = find_codes(brick.payload, in_brick(cell)).width;
    return max(max(most.x, most.y), max(most.z, most.w)) >= real(int((1u << width) - 1u));
  }
  real4 sum = c.lo + c.hi;
  return is_nan((sum.x + sum.y) + (sum.z + sum.w));
}

// The density's node as a turn sees it: a cell with an absent corner is a node of its own.
Node with_data(Node node, int3 cell) {
  if (!absent_voxels) return node;
  if (node.kind == NODE_CONSTANT) {
    if (is_nan(fetch_constant(density_grid, node.payload))) node = absent_node(node.lo, node.side);
  } else if (node.kind == NODE_BRICK) {
    if (lacks_corner(node, cell)) node = absent_node(cell, 1);
  }
  return node;
}

// The same for a walk that samples the node at any place: it is a single cell.
Node sampled_node(Node node, int3 cell) {
  if (!absent_voxels) return node;
  node = with_data(node, cell);
  if (node.kind == NODE_BRICK) node = Node(NODE_BRICK, node.payload, cell, 1);
  return node;
}

// Value at a position inside a node that is not empty.
real sample_scalar(int grid, Node node, real3 p) {
  real3 local = p - real3(first_cell(node));
  int3 cell = local_cell(node, local);
  real v;
  if (node.kind == NODE_CONSTANT) v = fetch_constant(grid, node.payload);
  else if (hardware_filter) v = filtered_texel(grid, node.payload, by_voxel(grid) ? real3(cell) : local);
  else v = trilinear(fetch_corners(grid, node, cell), local - real3(cell));
  return v;
}

// Between a texel and the next one along x.
real3 along_x(int grid, int i, real u) {
  return mix(fetch_texel3(grid, i), fetch_texel3(grid, i + NEXT_X), u);
}

// Between the texels of a brick, at a place given from its first one.
real3 trilinear_texels(int grid, int slot, real3 local) {
  int3 cell = local_cell(local);
  real3 u = local - real3(cell);
  int i = texel_index(slot, cell);
  if (by_voxel(grid)) return fetch_texel3(grid, i);
  real3 x00 = along_x(grid, i, u.x);
  real3 x01 = along_x(grid, i + NEXT_Z, u.x);
  real3 x10 = along_x(grid, i + NEXT_Y, u.x);
  real3 x11 = along_x(grid, i + NEXT_Y + NEXT_Z, u.x);
  return mix(mix(x00, x10, u.y), mix(x01, x11, u.y), u.z);
}

real3 sample_vector(int grid, Node node, real3 p) {
  real3 local = p - real3(first_cell(node));
  real3 v;
  if (node.kind == NODE_CONSTANT) v = fetch_constant3(grid, node.payload);
  else if (hardware_filter)
    v = filtered_texel3(grid, node.payload, by_voxel(grid) ? real3(local_cell(local)) : local);
  else v = trilinear_texels(grid, node.payload, local);
  return v;
}

// The texels along u + d s inside a cell, the first of whose is texel i.
Cubics texels_along(int grid, int i, real3 u, real3 d) {
  real3 a = fetch_texel3(grid, i);
  if (by_voxel(grid)) return constant_cubics(a);
  real3 b = fetch_texel3(grid, i + NEXT_Z);
  real3 c = fetch_texel3(grid, i + NEXT_Y);
  real3 e = fetch_texel3(grid, i + NEXT_Y + NEXT_Z);
  real3 f = fetch_texel3(grid, i + NEXT_X);
  real3 g = fetch_texel3(grid, i + NEXT_X + NEXT_Z);
  real3 h = fetch_texel3(grid, i + NEXT_X + NEXT_Y);
  real3 k = fetch_texel3(grid, i + NEXT_X + NEXT_Y + NEXT_Z);
  return Cubics(cubic_along(plain_corners(real4(a.x, b.x, c.x, e.x), real4(f.x, g.x, h.x, k.x)), u, d),
                cubic_along(plain_corners(real4(a.y, b.y, c.y, e.y), real4(f.y, g.y, h.y, k.y)), u, d),
                cubic_along(plain_corners(real4(a.z, b.z, c.z, e.z), real4(f.z, g.z, h.z, k.z)), u, d));
}

// A grid along p + d s, s in [0, 1], inside one of its cells, of a node that is not empty.
Cubics cubics_inside(int grid, int channels, Node node, real3 p, real3 d) {
  Cubics v;
  if (hardware_filter && channels == 1) {
    v.x = make_cubic(sample_scalar(grid, node, p), sample_scalar(grid, node, p + d * real(0.5)),
                     sample_scalar(grid, node, p + d), real(0.0));
    v = Cubics(v.x, v.x, v.x);
  } else if (hardware_filter) {
    v = parabolas(sample_vector(grid, node, p), sample_vector(grid, node, p + d * real(0.5)),
                  sample_vector(grid, node, p + d));
  } else {
    int3 cell = local_cell(p + d * real(0.5) - real3(first_cell(node)));
    real3 u = p - real3(first_cell(node) + cell);
    if (channels == 1) {
      v.x = cubic_along(fetch_corners(grid, node, cell), u, d);
      v = Cubics(v.x, v.x, v.x);
    } else if (node.kind == NODE_CONSTANT) {
      v = constant_cubics(fetch_constant3(grid, node.payload));
    } else {
      v = texels_along(grid, texel_index(node.payload, cell), u, d);
    }
  }
  return v;
}

// The same, of any node.
Cubics cubics_along(int grid, int channels, Node node, real3 p, real3 d) {
  Cubics v = constant_cubics(real3(real(0.0)));
  if (node.kind != NODE_EMPTY) v = cubics_inside(grid, channels, node, p, d);
  return v;
}

// The luminance beside the density along u + d s inside the pairs' cell.
Cubics cubics_along(IN(Pairs) p, int channels, real3 u, real3 d) {
  Cubic x = cubic_along(luminances_x(p), u, d);
  if (channels == 1) return Cubics(x, x, x);
  return Cubics(x, cubic_along(luminances_y(p), u, d), cubic_along(luminances_z(p), u, d));
}

// Half the way over which slopes are measured where the driver filters [unit of t].
#if REAL_BITS == 64
const real slope_step = real(1e-4);
#else
const real slope_step = real(0.03125);
#endif

// A grid's value and its derivative along its ray [1 / unit of t].
struct Tangent {
  real value;
  real slope;
};

// The tangent at a point of a brick.
Tangent tangent_scalar(int grid, Node node, Ray ray, real t) {
  real3 p = position(ray, t);
  if (hardware_filter)
    return Tangent(sample_scalar(grid, node, p),
                   (sample_scalar(grid, node, position(ray, t + slope_step))
                    - sample_scalar(grid, node, position(ray, t - slope_step))) / (real(2.0) * slope_step));
  real3 local = p - real3(first_cell(node));
  int3 cell = local_cell(node, local);
  Corners corners = fetch_corners(grid, node, cell);
  real3 u = local - real3(cell);
  return Tangent(trilinear(corners, u), dot(trilinear_gradient(corners, u), ray.direction));
}

// The derivative at a point of a node.
real slope_scalar(int grid, Node node, Ray ray, real t) {
  real slope = real(0.0);
  if (node.kind == NODE_BRICK) slope = tangent_scalar(grid, node, ray, t).slope;
  return slope;
}

// The derivative of a vector at a point of a node.
real3 slope_vector(int grid, Node node, Ray ray, real t) {
  if (node.kind != NODE_BRICK || by_voxel(grid)) return real3(real(0.0));
  if (hardware_filter)
    return (sample_vector(grid, node, position(ray, t + slope_step))
            - sample_vector(grid, node, position(ray, t - slope_step))) / (real(2.0) * slope_step);
  real3 local = position(ray, t) - real3(first_cell(node));
  int3 cell = local_cell(local);
  real3 u = local - real3(cell);
  int i = texel_index(node.payload, cell);
  // each edge along x: its value at u.x, and its difference
  real3 a00 = fetch_texel3(grid, i);
  real3 a01 = fetch_texel3(grid, i + NEXT_Z);
  real3 a10 = fetch_texel3(grid, i + NEXT_Y);
  real3 a11 = fetch_texel3(grid, i + NEXT_Y + NEXT_Z);
  real3 d00 = fetch_texel3(grid, i + NEXT_X) - a00;
  real3 d01 = fetch_texel3(grid, i + NEXT_X + NEXT_Z) - a01;
  real3 d10 = fetch_texel3(grid, i + NEXT_X + NEXT_Y) - a10;
  real3 d11 = fetch_texel3(grid, i + NEXT_X + NEXT_Y + NEXT_Z) - a11;
  a00 = a00 + d00 * u.x;
  a01 = a01 + d01 * u.x;
  a10 = a10 + d10 * u.x;
  a11 = a11 + d11 * u.x;
  real3 slope_x = mix(mix(d00, d10, u.y), mix(d01, d11, u.y), u.z);
  real3 slope_y = mix(a10 - a00, a11 - a01, u.z);
  real3 slope_z = mix(a01 - a00, a11 - a10, u.y);
  return slope_x * ray.direction.x + slope_y * ray.direction.y + slope_z * ray.direction.z;
}
