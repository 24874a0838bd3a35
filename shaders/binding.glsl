// GLSL's side of the edge: types, uniforms, textures. The march in double has its own
// (src/march/glsl_subset.h).
#define REAL_BITS 32
#define real float
#define real2 vec2
#define real3 vec3
#define real4 vec4
#define int3 ivec3

#define PARAMETER(type, name) uniform type name;
#include "march_parameters.glsl"

float power_of_two(int n) { return intBitsToFloat((n + 127) << 23); }

// A grid's texels are one texture buffer after the other, TEXELS_PER_BUFFER in each but the last;
// with --filter hardware one 3D texture of bricks instead.
uniform usamplerBuffer density_pages;
uniform usamplerBuffer luminance_pages;
uniform samplerBuffer density_constants;
uniform samplerBuffer luminance_constants;
uniform samplerBuffer density_texels[DENSITY_BUFFERS];
uniform samplerBuffer luminance_texels[LUMINANCE_BUFFERS];
uniform sampler3D density_bricks;
uniform sampler3D luminance_bricks;

uint fetch_page(int grid, int i) {
  return grid == 0 ? texelFetch(density_pages, i).x : texelFetch(luminance_pages, i).x;
}

float fetch_constant(int grid, int i) {
  return grid == 0 ? texelFetch(density_constants, i).x : texelFetch(luminance_constants, i).x;
}

vec3 fetch_constant3(int grid, int i) { return texelFetch(luminance_constants, i).xyz; }

#if DENSITY_BUFFERS == 1
vec4 density_texel(int i) { return texelFetch(density_texels[0], i); }
#else
vec4 density_texel(int i) {
  int b = i / TEXELS_PER_BUFFER;
  int k = i - b * TEXELS_PER_BUFFER;
  for (int j = 0; j < DENSITY_BUFFERS - 1; ++j)
    if (j == b) return texelFetch(density_texels[j], k);
  return texelFetch(density_texels[DENSITY_BUFFERS - 1], k);
}
#endif

#if LUMINANCE_BUFFERS == 1
vec4 luminance_texel(int i) { return texelFetch(luminance_texels[0], i); }
#else
vec4 luminance_texel(int i) {
  int b = i / TEXELS_PER_BUFFER;
  int k = i - b * TEXELS_PER_BUFFER;
  for (int j = 0; j < LUMINANCE_BUFFERS - 1; ++j)
    if (j == b) return texelFetch(luminance_texels[j], k);
  return texelFetch(luminance_texels[LUMINANCE_BUFFERS - 1], k);
}
#endif

float fetch_texel(int grid, int i) { return grid == 0 ? density_texel(i).x : luminance_texel(i).x; }
vec3 fetch_texel3(int grid, int i) { return luminance_texel(i).xyz; }

// `slot` is the brick's place in the 3D texture here, 10 bits an axis (see AtlasTextures).
vec4 filtered(sampler3D bricks, int slot, vec3 local) {
  ivec3 texel = ivec3(slot & 1023, (slot >> 10) & 1023, slot >> 20) * 9;
  // a texel's centre is at +0.5; z is the fastest axis
  return textureLod(bricks, (vec3(texel) + local.zyx + 0.5) / vec3(textureSize(bricks, 0)), 0.0);
}

float filtered_texel(int grid, int slot, vec3 local) {
  return grid == 0 ? filtered(density_bricks, slot, local).x
                   : filtered(luminance_bricks, slot, local).x;
}
vec3 filtered_texel3(int grid, int slot, vec3 local) {
  return filtered(luminance_bricks, slot, local).xyz;
}
