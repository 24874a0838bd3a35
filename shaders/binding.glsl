// GLSL's side of the edge: types, uniforms, textures. The march in double has its own
// (src/march/glsl_subset.h).
#define REAL_BITS 32
#define real float
#define real2 vec2
#define real3 vec3
#define real4 vec4
#define int3 ivec3
#define INOUT(type) inout type
#define IN(type) type

#define DERIVED(type, name, expression) const type name = expression;

// What a loop reads of a uniform llvmpipe (Mesa 22.3) gathers lane by lane in every turn, at 35 instructions a
// number. A sum with what it cannot know to be 0 is formed once, before the loop.
#if HOLDS_UNIFORMS
int nothing = int(gl_FragCoord.x) >> 30;
#define HELD(type, uniform_value) (uniform_value + type(nothing))
#else
#define HELD(type, uniform_value) uniform_value
#endif

struct Parameters {
#define PARAMETER(type, name) type name;
#include "march_parameters.glsl"
#undef PARAMETER
};
uniform Parameters given;
#define PARAMETER(type, name) type name = HELD(type, given.name);
#include "march_parameters.glsl"

float power_of_two(int n) { return intBitsToFloat((n + 127) << 23); }

// A grid's texels are one texture buffer after the other, TEXELS_PER_BUFFER in each but the last;
// with --filter hardware one 3D texture of bricks instead.
uniform samplerBuffer tables;  // what transfer functions and rules look up
uniform usamplerBuffer density_pages;
uniform samplerBuffer density_constants;
uniform samplerBuffer density_texels[DENSITY_BUFFERS];
uniform sampler3D density_bricks;
uniform usamplerBuffer luminance_pages;
uniform samplerBuffer luminance_constants;
uniform samplerBuffer luminance_texels[LUMINANCE_BUFFERS];
uniform sampler3D luminance_bricks;
uniform usamplerBuffer emission_pages;
uniform samplerBuffer emission_constants;
uniform samplerBuffer emission_texels[EMISSION_BUFFERS];
uniform sampler3D emission_bricks;
uniform usamplerBuffer gradient_pages;
uniform samplerBuffer gradient_constants;
uniform samplerBuffer gradient_texels[GRADIENT_BUFFERS];
uniform sampler3D gradient_bricks;

vec4 fetch_table(int i) { return texelFetch(tables, i); }

// Of a transfer function of one interval: its two knots' entries.
uniform vec4 interval_entries[8];
#define HELD_ENTRY(i) HELD(vec4, interval_entries[i])
vec4 only_interval[8] = vec4[8](HELD_ENTRY(0), HELD_ENTRY(1), HELD_ENTRY(2), HELD_ENTRY(3), HELD_ENTRY(4),
                                HELD_ENTRY(5), HELD_ENTRY(6), HELD_ENTRY(7));
vec4 fetch_interval(int i) { return only_interval[i]; }

uint fetch_page(int grid, int i) {
  return grid == 0 ? texelFetch(density_pages, i).x
       : grid == 1 ? texelFetch(luminance_pages, i).x
       : grid == 2 ? texelFetch(emission_pages, i).x : texelFetch(gradient_pages, i).x;
}

vec3 fetch_constant3(int grid, int i) {
  return grid == 0 ? texelFetch(density_constants, i).xyz
       : grid == 1 ? texelFetch(luminance_constants, i).xyz
       : grid == 2 ? texelFetch(emission_constants, i).xyz
                   : texelFetch(gradient_constants, i).xyz;
}

float fetch_constant(int grid, int i) { return fetch_constant3(grid, i).x; }

// Texels fill one buffer after the other. Where there is one, the loop over several is dropped at once: it
// would be inlined for every texel of every grid, half the time to build a program.
#define FETCH_TEXEL(name, textures, buffers) \
  vec4 name(int i) { \
    if (buffers == 1) { \
      return texelFetch(textures[0], i); \
    } else { \
      int b = i / TEXELS_PER_BUFFER; \
      int k = i - b * TEXELS_PER_BUFFER; \
      for (int j = 0; j < buffers - 1; ++j) \
        if (j == b) return texelFetch(textures[j], k); \
      return texelFetch(textures[buffers - 1], k); \
    } \
  }
FETCH_TEXEL(density_texel, density_texels, DENSITY_BUFFERS)
FETCH_TEXEL(luminance_texel, luminance_texels, LUMINANCE_BUFFERS)
FETCH_TEXEL(emission_texel, emission_texels, EMISSION_BUFFERS)
FETCH_TEXEL(gradient_texel, gradient_texels, GRADIENT_BUFFERS)

vec3 fetch_texel3(int grid, int i) {
  return grid == 0 ? density_texel(i).xyz
       : grid == 1 ? luminance_texel(i).xyz
       : grid == 2 ? emission_texel(i).xyz : gradient_texel(i).xyz;
}
float fetch_texel(int grid, int i) { return fetch_texel3(grid, i).x; }

// `slot` is the brick's place in the 3D texture here, 10 bits an axis (see AtlasTextures).
vec4 filtered(sampler3D bricks, int slot, vec3 local) {
  ivec3 texel = ivec3(slot & 1023, (slot >> 10) & 1023, slot >> 20) * 9;
  // a texel's centre is at +0.5; z is the fastest axis
  return textureLod(bricks, (vec3(texel) + local.zyx + 0.5) / vec3(textureSize(bricks, 0)), 0.0);
}

vec3 filtered_texel3(int grid, int slot, vec3 local) {
  return grid == 0 ? filtered(density_bricks, slot, local).xyz
       : grid == 1 ? filtered(luminance_bricks, slot, local).xyz
       : grid == 2 ? filtered(emission_bricks, slot, local).xyz
                   : filtered(gradient_bricks, slot, local).xyz;
}
float filtered_texel(int grid, int slot, vec3 local) {
  return filtered_texel3(grid, slot, local).x;
}
