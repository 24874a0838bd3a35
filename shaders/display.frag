// A picture's radiance, encoded for the screen. See src/view/picture_display.h. Rows are the
// picture's, top first.
uniform sampler2D picture;
uniform sampler2D other;    // of a difference
uniform int difference;     // 1: picture - other
uniform float exposure;     // factor of the radiance
uniform int tone_map;       // a value of ToneMap
uniform int by_view;        // 1: view_codes encode the picture
uniform sampler3D view_codes;  // of light from 0 on: darkest (2^(octaves u) - 1) at place u
uniform float view_darkest;
uniform float view_octaves;
uniform float gain;         // of the difference
uniform vec3 background;

layout(location = 0) out vec4 out_color;

#define real float
#include "math/colour.glsl"

float encoded(float light) { return srgb_from_linear(min(light, 1.0)); }

vec3 viewed(vec3 light) {
  vec3 u = clamp(log2(max(light, 0.0) / view_darkest + 1.0) / view_octaves, 0.0, 1.0);
  vec3 size = vec3(textureSize(view_codes, 0));
  return texture(view_codes, (u * (size - 1.0) + 0.5) / size).rgb;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 color = texelFetch(picture, pixel, 0);
  if (color.a < 0.0) discard;  // not there yet
  vec3 radiance = (color.rgb + (1.0 - color.a) * background) * exposure;
  if (by_view == 1) {
    out_color = vec4(viewed(radiance), 1.0);
    return;
  }
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
