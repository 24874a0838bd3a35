#include "marcher.glsl"

// Row 0 of the framebuffer is the picture's top row of the tile.
uniform ivec2 tile_origin;

layout(location = 0) out vec4 out_picture;  // R G B A
layout(location = 1) out vec4 out_layers;   // depth [world], transmittance, steps, samples

#include "passes.glsl"

void main() {
  Pixel p = make_pixel(floor(gl_FragCoord.xy) + vec2(tile_origin));
  Ray ray = march_ray_of(p);
  March m = begin_march(ray);
#if RESUMABLE
  if (!first_pass) load_march(m, ivec2(gl_FragCoord.xy), ray.begin);
#endif
  aim(m, p);
  march(m, ray);
#if RESUMABLE
  save_march(m);
#endif
  out_picture = drawn(m, ray, p);
  if (m.stuck) out_picture.w += float(STUCK_MARK);
  out_layers = vec4(depth_of(m, p), decay(m.optical_depth).e, float(m.steps), float(m.samples));
}
