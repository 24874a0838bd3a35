// A pixel and its rays in the grids.

// Where the ray of a pixel runs in a grid, in that grid's voxels.
struct Pixel {
  real u;
  real v;
  real inverse_length;  // of the world direction
  int number;           // has_passed: among the rays that are drawn
  int held;             // holds_out: among those of the whole picture
};

Pixel make_pixel(real2 pixel) {
  real u = real(2.0) * (pixel.x + sample_offset.x) / image_size.x - real(1.0);
  real v = real(1.0) - real(2.0) * (pixel.y + sample_offset.y) / image_size.y;
  real3 w = world_0 + world_u * u + world_v * v;
  int number = (int(pixel.y) - passed_y) * passed_width + int(pixel.x) - passed_x;
  int held = int(pixel.y) * held_width + int(pixel.x);
  return Pixel(u, v, real(1.0) / sqrt(dot(w, w)), number, held);
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

// A number of a table that has four of them an entry.
real table_number(int first, int number) {
  real4 four = fetch_table(first + (number >> 2));
  int i = number & 3;
  return i < 2 ? (i == 0 ? four.x : four.y) : (i == 2 ? four.z : four.w);
}

// The ray up to its pixel's opaque depth. All rays of a pixel end in one plane across the view.
Ray held_ray(Ray ray, Pixel p) {
  if (!holds_out) return ray;
  real z = table_number(held_first, p.held);
  ray.end = min(ray.end, orthographic ? z : z / p.inverse_length);
  return ray;
}

// The ray that is marched: from the camera, or back to front.
Ray march_ray_of(Pixel p) {
  Ray ray = held_ray(clipped_ray(grid_ray(p, density), p), p);
  if (from_back) return reversed(ray);
  return ray;
}

// Towards the light: the ray from a voxel of the density grid to where the light comes in. The view
// of such a march looks there, orthographic (light_march in light.h). A ray in an upper face of the
// domain stays inside: what lies there is as deep as what lies just below. A voxel that is a cell of
// one value has its middle half a voxel further.
Ray light_ray(int3 voxel) {
  real3 d = density.direction_0;
  real3 at = real3(voxel);
  if (nearest) {
    at += real(0.5);
  } else {
    d.x = along_face(d.x, voxel.x, density.domain_max.x);
    d.y = along_face(d.y, voxel.y, density.domain_max.y);
    d.z = along_face(d.z, voxel.z, density.domain_max.z);
  }
  return make_ray(at, d, density.domain_min, density.domain_max, real(0.0));
}
