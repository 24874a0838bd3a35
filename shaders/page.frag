// The picture on a page, encoded for the screen. Its rows are top first, the screen's are not.
uniform sampler2D fine;      // sums over a pixel's samples; alpha below 0: not there yet
uniform sampler2D coarse;    // what is shown until then
uniform ivec2 size;          // of the picture [pixels]
uniform ivec2 coarse_size;   // of the part of `coarse` that was drawn
uniform float samples;       // of a pixel of `fine`
uniform float exposure;      // factor of the radiance
uniform int tone_map;        // a value of ToneMap
uniform vec3 background;

layout(location = 0) out vec4 out_color;

#define real float
#include "math/colour.glsl"

float encoded(float radiance) { return srgb_from_linear(min(display_light(radiance, tone_map), 1.0)); }

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  pixel.y = size.y - 1 - pixel.y;
  vec4 color = texelFetch(fine, pixel, 0);
  if (color.a < 0.0) color = texelFetch(coarse, pixel * coarse_size / size, 0);
  else color /= samples;
  vec3 radiance = (color.rgb + (1.0 - color.a) * background) * exposure;
  out_color = vec4(encoded(radiance.r), encoded(radiance.g), encoded(radiance.b), 1.0);
}
