#include "marcher.glsl"

// The picture's pixel that the tile's first one is.
uniform ivec2 tile_origin;

#include "passes.glsl"

// The picture is R G B A, the layers are depth [world], transmittance, steps and samples.
void draw(ivec2 at) {
  Pixel p = make_pixel(vec2(at) + vec2(tile_origin));
  Ray ray = march_ray_of(p);
  March m = begin_march(ray);
#if RESUMABLE
  if (!first_pass) load_march(m, at);
#endif
  aim(m, p);
  march(m, ray);
#if RESUMABLE
  save_march(m, at);
#endif
  out_picture = drawn(m, ray);
  if (m.stuck) out_picture.w += float(STUCK_MARK);
  out_layers = vec4(depth_of(m, p), decay(m.optical_depth).e, float(m.steps), float(m.samples));
}

#include "main.glsl"
