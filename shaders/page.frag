// The picture on a page, encoded for the screen. Its rows are top first, the screen's are not.
uniform sampler2D fine;      // sums over a pixel's samples; alpha below 0: not there yet
uniform sampler2D coarse;    // what is shown until then
uniform ivec2 size;          // of the picture [pixels]
uniform ivec2 coarse_size;   // of the part of `coarse` that was drawn
uniform float samples;       // of a pixel of `fine`
uniform float exposure;      // factor of the radiance
uniform int tone_map;        // a value of ToneMap
uniform vec3 background;
uniform float contrast;      // factor of the medium's light before this background

layout(location = 0) out vec4 out_color;

#define real float
#include "math/colour.glsl"

// The coarse picture between the middles of its pixels.
vec4 coarse_at(ivec2 pixel) {
  vec2 place = (vec2(pixel) + 0.5) * vec2(coarse_size) / vec2(size) - 0.5;
  ivec2 low = ivec2(floor(place));
  vec2 part = place - vec2(low);
  ivec2 last = coarse_size - 1;
  vec4 a = texelFetch(coarse, clamp(low, ivec2(0), last), 0);
  vec4 b = texelFetch(coarse, clamp(low + ivec2(1, 0), ivec2(0), last), 0);
  vec4 c = texelFetch(coarse, clamp(low + ivec2(0, 1), ivec2(0), last), 0);
  vec4 d = texelFetch(coarse, clamp(low + ivec2(1, 1), ivec2(0), last), 0);
  return mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
}

float encoded(float radiance) { return srgb_from_linear(min(display_light(radiance, tone_map), 1.0)); }

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  pixel.y = size.y - 1 - pixel.y;
  vec4 color = texelFetch(fine, pixel, 0);
  if (color.a < 0.0) color = coarse_at(pixel);
  else color /= samples;
  vec3 radiance = (contrast * color.rgb + (1.0 - color.a) * background) * exposure;
  out_color = vec4(encoded(radiance.r), encoded(radiance.g), encoded(radiance.b), 1.0);
}
