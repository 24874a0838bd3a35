// A pixel: its rays in the grids, and the picture that it makes of them.

// Where the ray of a pixel runs in a grid, in that grid's voxels.
struct Pixel {
  real u;
  real v;
  real inverse_length;  // of the world direction
  int number;           // has_passed: among the rays that are drawn
};

Pixel make_pixel(real2 pixel) {
  real u = real(2.0) * (pixel.x + sample_offset.x) / image_size.x - real(1.0);
  real v = real(1.0) - real(2.0) * (pixel.y + sample_offset.y) / image_size.y;
  real3 w = world_0 + world_u * u + world_v * v;
  int number = (int(pixel.y) - passed_y) * passed_width + int(pixel.x) - passed_x;
  return Pixel(u, v, real(1.0) / sqrt(dot(w, w)), number);
}

real camera_time(Pixel p) {
  return orthographic ? -camera_distance : -camera_distance / p.inverse_length;
}

Ray grid_ray(Pixel p, IN(Grid) g) {
  return make_ray(g.anchor_0 + g.anchor_u * p.u + g.anchor_v * p.v,
                  (g.direction_0 + g.direction_u * p.u + g.direction_v * p.v) * p.inverse_length,
                  g.domain_min, g.domain_max, camera_time(p));
}

// Henyey and Greenstein's phase function over the isotropic one, of the angle between the light's
// way in and its way out, which is against the ray.
real phase_of(Pixel p) {
  if (!anisotropic) return real(1.0);
  real3 w = world_0 + world_u * p.u + world_v * p.v;
  real cosine = -dot(phase_axis, w) * p.inverse_length;
  real x = real(1.0) + phase_g * phase_g - real(2.0) * phase_g * cosine;
  return (real(1.0) - phase_g * phase_g) / (x * sqrt(x));
}

// An affine function of u and v from two entries: its coefficients, and what float32 left of them.
real affine(int entry, Pixel p) {
  real4 a = fetch_table(entry);
  real4 b = fetch_table(entry + 1);
  return (a.x + a.y * p.u + a.z * p.v) + (b.x + b.y * p.u + b.z * p.v);
}

// The part of the ray that the clip leaves: where distance + t speed >= 0 for each of its planes.
Ray clipped_ray(Ray ray, Pixel p) {
  if (!clips) return ray;
  for (int i = 0; i < clip_planes; ++i) {
    real distance = affine(clip_first + 4 * i, p);
    real speed = affine(clip_first + 4 * i + 2, p) * p.inverse_length;
    if (speed > real(0.0)) ray.begin = max(ray.begin, -distance / speed);
    else if (speed < real(0.0)) ray.end = min(ray.end, -distance / speed);
    else if (distance < real(0.0)) ray.end = ray.begin;
  }
  return ray;
}

// The ray that is marched: from the camera, or back to front.
Ray march_ray_of(Pixel p) {
  Ray ray = clipped_ray(grid_ray(p, density), p);
  if (mode == MODE_BACK_TO_FRONT) return reversed(ray);
  return ray;
}

// The optical depth that a ray has passed before its region.
real passed_depth(Pixel p) {
  real4 four = fetch_table(passed_first + (p.number >> 2));
  int i = p.number & 3;
  return i < 2 ? (i == 0 ? four.x : four.y) : (i == 2 ? four.z : four.w);
}

// The phase, the rays in the other grids, and what was passed, which no pass keeps.
void aim(INOUT(March) m, Pixel p) {
  m.phase = phase_of(p);
  if (has_passed) {
    real passed = passed_depth(p);
    m.half_at -= passed;
    m.stop_at -= passed;
    if (passed > stop_depth) m.done = true;
  }
  if (own_luminance) m.luminance.ray = grid_ray(p, luminance);
  if (has_emission) m.emission.ray = grid_ray(p, emission);
  if (mode == MODE_BACK_TO_FRONT) {
    m.luminance.ray = reversed(m.luminance.ray);
    m.emission.ray = reversed(m.emission.ray);
  }
}

// The density at a point of a cell.
real density_at(int3 cell, real3 p) {
  Node node = find_stored(density_grid, clamp(cell, density.domain_min, density.domain_max - 1));
  return node.kind == NODE_EMPTY ? real(0.0) : sample_scalar(density_grid, node, p);
}

// Where the ray hits a surface, in a cell: its normal in the world, 0 where the field has none, by
// central differences of the density one voxel to each side; at the domain's faces only as far as it
// reaches. The trilinear field's own gradient jumps from cell to cell. A point in a face has neighbours
// beside its cell, which are stored: those beside the cell across the face may not be.
real3 surface_normal(int3 cell, Ray ray, real t) {
  real3 p = position(ray, t);
  real3 n = real3(real(0.0));
  // No loop of known length, which would be unrolled: llvmpipe executes one turn for other rays.
  int sides = t < NEVER ? 6 : 0;
  for (int i = 0; i < sides; ++i) {
    int3 axis = int3(i < 2 ? 1 : 0, i >> 1 == 1 ? 1 : 0, i > 3 ? 1 : 0);
    int3 side = (i & 1) == 0 ? axis : -axis;
    real3 low = real3(density.domain_min);
    real3 high = real3(density.domain_max);
    real3 at = clamp(p + real3(side), low, high);
    real reach = dot(at - clamp(p - real3(side), low, high), real3(axis));  // with the side's sign
    real3 normal = i < 2 ? normal_x : i < 4 ? normal_y : normal_z;
    n = n + normal * (density_at(cell + side, at) / reach);
  }
  real size = sqrt(dot(n, n));
  return n * (size > real(0.0) ? real(1.0) / size : real(0.0));
}

// A surface is lit by the scene's lights, or by one from the camera, and from everywhere.
real3 shade(IN(March) m, Ray ray, Pixel p) {
  real3 w = (world_0 + world_u * p.u + world_v * p.v) * p.inverse_length;
  real3 normal = surface_normal(m.cell, ray, m.half_depth);
  if (dot(normal, w) > real(0.0)) normal = -normal;  // seen from either side
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

// Whether a ray has met a maximum, and one that attenuates.
bool sees_maximum(IN(March) m) {
  if (!(m.radiance.x > UNKNOWN)) return false;
  return (transfer ? classify(m.radiance.x).attenuation : m.radiance.x) > real(0.0);
}

// Distance from the camera of what the depth layer shows [world units]; NEVER where that is nothing.
real depth_of(IN(March) m, Pixel p) {
  if (m.half_depth >= NEVER || (finds_maximum && !sees_maximum(m))) return NEVER;
  return (m.half_depth - camera_time(p)) * world_unit;
}

// Premultiplied radiance and opacity.
real4 picture(IN(March) m, Ray ray, Pixel p) {
  if (finds_maximum) {
    if (!sees_maximum(m)) return real4(real(0.0));
    real3 shown = real3(m.radiance.x);
    if (luminance_source == SOURCE_TRANSFER) shown = classify(m.radiance.x).color;
    return real4(color * shown, real(1.0));
  }
  if (mode == MODE_ISOSURFACE) {
    if (m.half_depth >= NEVER) return real4(real(0.0));
    real3 shown = color;
    if (luminance_source == SOURCE_TRANSFER) shown = color * classify(isovalue).color;
    return real4(shown * shade(m, ray, p), real(1.0));
  }
  real a = decay(m.optical_depth).a;
  if (mode == MODE_XRAY) return real4(color * m.optical_depth, a);
  if (constant_luminance && !has_emission) return real4(color * a, a);
  real3 shown = m.radiance;
  if (!vector_radiance) shown = color * (m.phase * m.radiance.x);
  else if (!has_emission) shown = color * m.phase * m.radiance;
  return real4(shown + ambient * a, a);
}

// What a ray has collected in a region, for RayFold (src/march/ray_fold.h) to join with other regions':
// radiance and transmittance, which is 0 behind a surface; of maxima the value, and 1 if LMIP ended there.
// The ray is the one marched: made again, its end might differ by rounding.
real4 collected(IN(March) m, Ray ray, Pixel p) {
  if (finds_maximum) {
    bool found = mode == MODE_LMIP && m.done && m.t < ray.end;
    return real4(m.radiance.x, real(found ? 1.0 : 0.0), real(0.0), real(0.0));
  }
  real4 shown = picture(m, ray, p);
  real through = mode == MODE_ISOSURFACE ? real(1.0) - shown.w : decay(m.optical_depth).e;
  return real4(shown.x, shown.y, shown.z, through);
}

// What is drawn of a ray.
real4 drawn(IN(March) m, Ray ray, Pixel p) {
  if (in_part) return collected(m, ray, p);
  return picture(m, ray, p);
}
