// The baseline: a dense 3D texture of the whole domain, no skipping, a Porter-Duff step of the
// front sample at every multiple of `step`. A ray marcher written in an afternoon does this.
#include "stage.glsl"
#include "binding.glsl"
#include "math/decay.glsl"
#include "ray.glsl"

uniform sampler3D volume;  // z fastest: texture axes are (z, y, x)
uniform ivec2 tile_origin;


float field(vec3 p) {
  vec3 local = p - vec3(density.domain_min);
  if (hardware_filter)
    return textureLod(volume, (local.zyx + 0.5) / vec3(textureSize(volume, 0)), 0.0).x;
  ivec3 c = clamp(ivec3(floor(local)), ivec3(0), density.domain_max - density.domain_min - 1);
  vec3 u = local - vec3(c);
  ivec3 t = c.zyx;
  float v000 = texelFetch(volume, t, 0).x, v001 = texelFetch(volume, t + ivec3(1, 0, 0), 0).x;
  float v010 = texelFetch(volume, t + ivec3(0, 1, 0), 0).x;
  float v011 = texelFetch(volume, t + ivec3(1, 1, 0), 0).x;
  float v100 = texelFetch(volume, t + ivec3(0, 0, 1), 0).x;
  float v101 = texelFetch(volume, t + ivec3(1, 0, 1), 0).x;
  float v110 = texelFetch(volume, t + ivec3(0, 1, 1), 0).x;
  float v111 = texelFetch(volume, t + ivec3(1, 1, 1), 0).x;
  return mix(mix(mix(v000, v100, u.x), mix(v010, v110, u.x), u.y),
             mix(mix(v001, v101, u.x), mix(v011, v111, u.x), u.y), u.z);
}

void draw(ivec2 at) {
  vec2 pixel = vec2(at) + vec2(tile_origin) + sample_offset;
  float u = 2.0 * pixel.x / image_size.x - 1.0;
  float v = 1.0 - 2.0 * pixel.y / image_size.y;
  vec3 w = world_0 + world_u * u + world_v * v;
  float inverse_length = inversesqrt(dot(w, w));
  Ray ray = make_ray(density.anchor_0 + density.anchor_u * u + density.anchor_v * v,
                     (density.direction_0 + density.direction_u * u + density.direction_v * v)
                         * inverse_length,
                     density.domain_min, density.domain_max, -camera_distance / inverse_length);
  float T = 1.0;
  vec3 I = vec3(0.0);
  int first = int(ceil(ray.begin / step));
  int last = int(floor(ray.end / step));
  for (int k = first; k <= last; ++k) {
    float value = field(position(ray, float(k) * step));
    Decay d = decay(extinction * value * step);
#if LUMINANCE_DENSITY
    I += color * value * (T * d.a);
#else
    I += color * (T * d.a);
#endif
    T *= d.e;
    if (T < exp(-stop_depth)) break;
  }
  out_picture = vec4(I, 1.0 - T);
  out_layers = vec4(0.0);
}

#include "main.glsl"
