#include "marcher.glsl"

// One row is a block of 8^3 voxels, whose first one is entry blocks_first + row of `tables`.
uniform int blocks_first;

#include "passes.glsl"

// The picture is the optical depth, 0, 0, and 1 of a ray that stood still.
void draw(ivec2 at) {
  ivec3 first = ivec3(fetch_table(blocks_first + at.y).xyz);
  Ray ray = light_ray(first + ivec3(at.x >> 6, (at.x >> 3) & 7, at.x & 7));
  March m = begin_march(ray);
#if RESUMABLE
  if (!first_pass) load_march(m, at);
#endif
  march(m, ray);
#if RESUMABLE
  save_march(m, at);
#endif
  out_picture = vec4(m.optical_depth, 0.0, 0.0, m.stuck ? 1.0 : 0.0);
  out_layers = vec4(0.0);
}

#include "main.glsl"
