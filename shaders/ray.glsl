// A ray in a grid's voxels, p(t) = anchor + t direction, and the faces it crosses.
struct Ray {
  real3 anchor;
  real3 direction;  // no component is 0, see clamp_component
  real3 inverse;    // 1 / direction
  real begin;       // of the part inside the domain, from the camera on
  real end;         // end <= begin: the ray misses
};

// So that 1/d is finite. A ray turned by 1e-15 moves by 1e-9 voxels over a million, and the times of
// the faces of 2^24 voxels, 2^24 / 1e-15 = 2e22, are far from float32's largest number. A ray in a face
// ascends through it, so that all of them meet regions in one order (Regions::front_to_back).
const real least_component = real(1e-15);

real clamp_component(real d) { return abs(d) < least_component ? least_component : d; }

// The component of a ray from a voxel, which descends from an upper face if it is in that face.
real along_face(real d, int voxel, int upper) {
  return voxel == upper && abs(d) <= least_component ? -least_component : d;
}

// The one expression for the t of faces: cells, bricks, regions and the domain must agree bit for bit.
// `precise`: else a compiler may multiply out at one call and not at another, and a ray whose end is one
// ulp behind its last cell's leaves the page table.
real face_time(int face, real anchor, real inverse) {
  precise real away = real(face) - anchor;
  precise real t = away * inverse;
  return t;
}

real3 face_times(Ray ray, int3 faces) {
  return real3(face_time(faces.x, ray.anchor.x, ray.inverse.x),
               face_time(faces.y, ray.anchor.y, ray.inverse.y),
               face_time(faces.z, ray.anchor.z, ray.inverse.z));
}

real least(real3 v) { return min(v.x, min(v.y, v.z)); }
real greatest(real3 v) { return max(v.x, max(v.y, v.z)); }

// The faces of a box through which the ray leaves.
int3 far_faces(Ray ray, int3 lo, int3 hi) {
  return int3(ray.inverse.x > real(0.0) ? hi.x : lo.x, ray.inverse.y > real(0.0) ? hi.y : lo.y,
              ray.inverse.z > real(0.0) ? hi.z : lo.z);
}

// 1 where the ray ascends, else 0.
int3 side_of(Ray ray) { return far_faces(ray, int3(0), int3(1)); }

Ray make_ray(real3 anchor, real3 direction, int3 domain_min, int3 domain_max, real camera) {
  real3 d = real3(clamp_component(direction.x), clamp_component(direction.y),
                  clamp_component(direction.z));
  real3 inverse = real3(real(1.0) / d.x, real(1.0) / d.y, real(1.0) / d.z);
  Ray ray = Ray(anchor, d, inverse, camera, camera);
  ray.end = least(face_times(ray, far_faces(ray, domain_min, domain_max)));
  ray.begin = max(camera, greatest(face_times(ray, far_faces(ray, domain_max, domain_min))));
  return ray;
}

const real NEVER = real(1e30);  // a time that no ray reaches

// Faces of two grids nearer than this are taken as met [unit of t]: two lattices that are the same
// differ by rounding.
const real near_face = real(1e-4);

// The ray from its other end, with t negated. The times of all faces are negated too, to the last bit,
// since rounding is symmetric.
Ray reversed(Ray ray) {
  return Ray(ray.anchor, -ray.direction, -ray.inverse, -ray.end, -ray.begin);
}

real3 position(Ray ray, real t) { return ray.anchor + ray.direction * t; }

// The cell of the box [lo, hi) that holds the position at t: where rounding puts it outside, the
// nearest one inside. Positions of one t may differ by rounding between calls; nothing compares them.
int3 cell_at(Ray ray, real t, int3 lo, int3 hi) {
  return clamp(int3(floor(position(ray, t))), lo, hi - 1);
}

// The cell that the ray is in at t by the times of faces, from `cell`, which holds the position: the two
// differ by rounding where the ray is almost in a face. Regions must agree on which of them has the cell.
int3 cell_between_faces(Ray ray, real t, int3 cell) {
  int3 side = side_of(ray);
  real3 ends = face_times(ray, cell + side);
  real3 begins = face_times(ray, cell + 1 - side);
  int3 forward = side * 2 - 1;
  if (ends.x <= t) cell.x += forward.x;
  else if (begins.x > t) cell.x -= forward.x;
  if (ends.y <= t) cell.y += forward.y;
  else if (begins.y > t) cell.y -= forward.y;
  if (ends.z <= t) cell.z += forward.z;
  else if (begins.z > t) cell.z -= forward.z;
  return cell;
}

// Across the far face of a cube of cells: when, and the cell on the other side. That cell is taken
// from the face, not from the position, which may round back.
struct Crossing {
  real t;
  int3 cell;
};

// The cell behind a cube along one axis, where the ray leaves it at t; `at`: its place then. Times are
// compared with the least of themselves, so that at least one face is crossed.
int cell_behind(real face, real t, real at, real inverse, int lo, int side) {
  int beside = inverse > real(0.0) ? lo + side : lo - 1;
  return face <= t ? beside : clamp(int(floor(at)), lo, lo + side - 1);
}

// Axis by axis: all at once take up to 8 registers more.
Crossing leave(Ray ray, int3 lo, int side) {
  real3 times = face_times(ray, far_faces(ray, lo, lo + side));
  real t = least(times);
  int x = cell_behind(times.x, t, ray.anchor.x + ray.direction.x * t, ray.inverse.x, lo.x, side);
  int y = cell_behind(times.y, t, ray.anchor.y + ray.direction.y * t, ray.inverse.y, lo.y, side);
  int z = cell_behind(times.z, t, ray.anchor.z + ray.direction.z * t, ray.inverse.z, lo.z, side);
  return Crossing(t, int3(x, y, z));
}

// When the ray, which is in a cube of cells at t, next meets a face. By rounding its time may have come
// already, for long where the ray is almost in it: then the next face is a cell farther.
real next_face_time(Ray ray, int3 lo, int side, real t) {
  real3 times = face_times(ray, far_faces(ray, lo, lo + side));
  real3 farther = times + abs(ray.inverse);
  return least(real3(times.x > t ? times.x : farther.x, times.y > t ? times.y : farther.y,
                     times.z > t ? times.z : farther.z));
}

#if REAL_BITS == 64
const real t_epsilon = real(2.3e-16);
#else
const real t_epsilon = real(1.2e-7);
#endif

// End of the first `part` of the way from t on to t_exit: ahead of t by more than rounding, or the
// part would be met again for ever. However it is rounded: t_epsilon is more than half an ulp.
real part_end(real t, real length, real part, real t_exit) {
  real end = min(t_exit, max(t + part * length, t + abs(t) * t_epsilon + t_epsilon));
  return part >= real(1.0) ? t_exit : end;
}
