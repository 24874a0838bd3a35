// A picture's radiance, encoded for the screen. See src/view/picture_display.h. Rows are the
// picture's, top first.
uniform sampler2D picture;
uniform sampler2D other;    // of a difference
uniform int difference;     // 1: picture - other
uniform float exposure;     // factor of the radiance
uniform int tone_map;       // a value of ToneMap
uniform float gain;         // of the difference
uniform vec3 background;

layout(location = 0) out vec4 out_color;

#define real float
#include "math/colour.glsl"

float encoded(float light) { return srgb_from_linear(min(light, 1.0)); }

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 color = texelFetch(picture, pixel, 0);
  if (color.a < 0.0) discard;  // not there yet
  vec3 radiance = (color.rgb + (1.0 - color.a) * background) * exposure;
  vec3 shown = vec3(display_light(radiance.r, tone_map), display_light(radiance.g, tone_map),
                    display_light(radiance.b, tone_map));
  if (difference == 1) {
    vec4 second = texelFetch(other, pixel, 0);
    if (second.a < 0.0) discard;
    float d = clamp(gain * dot(color.rgb - second.rgb, vec3(1.0 / 3.0)), -1.0, 1.0);
    // white: equal; red: the picture is brighter; blue: the other one
    shown = d > 0.0 ? vec3(1.0, 1.0 - d, 1.0 - d) : vec3(1.0 + d, 1.0 + d, 1.0);
  }
  out_color = vec4(encoded(shown.r), encoded(shown.g), encoded(shown.b), 1.0);
}
