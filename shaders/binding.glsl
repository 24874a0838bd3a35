// GLSL's side of the edge: types, uniforms, textures. The march in double has its own
// (src/march/glsl_subset.h).
#define REAL_BITS 32
#define real float
#define real2 vec2
#define real3 vec3
#define real4 vec4
#define int3 ivec3
#define uint4 uvec4
#define INOUT(type) inout type
#define IN(type) type

#define DERIVED(type, name, expression) const type name = expression;

struct Grid {
#define PARAMETER(type, name) type name;
#include "grid_parameters.glsl"
#undef PARAMETER
};

// llvmpipe (Mesa 22.3) gathers a uniform lane by lane wherever a loop reads it, in every turn, at 35
// instructions a number. A sum is formed once, before the loop: the uniform plus a 0 that the driver
// cannot know.
#if HOLDS_UNIFORMS
int nothing = drawn_at().x >> 30;
int held(int v) { return v + nothing; }
ivec3 held(ivec3 v) { return v + nothing; }
float held(float v) { return v + float(nothing); }
vec2 held(vec2 v) { return v + float(nothing); }
vec3 held(vec3 v) { return v + float(nothing); }
vec4 held(vec4 v) { return v + float(nothing); }
Grid held(Grid v) {
#define PARAMETER(type, name) v.name = held(v.name);
#include "grid_parameters.glsl"
#undef PARAMETER
  return v;
}
#else
#define held(v) v
#endif

struct Parameters {
#define PARAMETER(type, name) type name;
#include "march_parameters.glsl"
#undef PARAMETER
};
uniform Parameters given;
#define PARAMETER(type, name) type name = held(given.name);
#include "march_parameters.glsl"
#undef PARAMETER

float real_of_bits(uint bits) { return uintBitsToFloat(bits); }
// By its bits: compilers may take it that no number is NaN.
bool is_nan(float v) { return (floatBitsToUint(v) & 0x7fffffffu) > 0x7f800000u; }
float power_of_two(int n) { return intBitsToFloat((n + 127) << 23); }

uniform samplerBuffer tables;  // what transfer functions and rules look up
vec4 fetch_table(int i) { return texelFetch(tables, i); }

// The entries of the two knots of a transfer function with one interval.
uniform vec4 interval_entries[8];
vec4 only_interval[8] = vec4[8](held(interval_entries[0]), held(interval_entries[1]), held(interval_entries[2]),
                           held(interval_entries[3]), held(interval_entries[4]), held(interval_entries[5]),
                           held(interval_entries[6]), held(interval_entries[7]));
vec4 fetch_interval(int i) { return only_interval[i]; }

#define GRID(id, name) const int name##_grid = id;
#include "grids.glsl"
#undef GRID

// A grid's texels are one texture buffer after the other, texels_per_buffer in each but the last;
// with --filter hardware one 3D texture of bricks instead. The loop over several buffers is inlined for
// every texel of every grid: where there is one it is not there, which halves the time to build a program.
#define GRID(id, name) \
  uniform usamplerBuffer name##_pages; \
  uniform samplerBuffer name##_constants; \
  uniform samplerBuffer name##_texels[name##_buffers]; \
  uniform sampler3D name##_bricks; \
  vec4 name##_texel(int i) { \
    if (name##_buffers == 1) { \
      return texelFetch(name##_texels[0], i); \
    } else { \
      int b = i / texels_per_buffer; \
      int k = i - b * texels_per_buffer; \
      for (int j = 0; j < name##_buffers - 1; ++j) \
        if (j == b) return texelFetch(name##_texels[j], k); \
      return texelFetch(name##_texels[name##_buffers - 1], k); \
    } \
  } \
  uniform usamplerBuffer name##_codes[name##_buffers]; \
  uvec4 name##_code(int i) { \
    if (name##_buffers == 1) { \
      return texelFetch(name##_codes[0], i); \
    } else { \
      int b = i / texels_per_buffer; \
      int k = i - b * texels_per_buffer; \
      for (int j = 0; j < name##_buffers - 1; ++j) \
        if (j == b) return texelFetch(name##_codes[j], k); \
      return texelFetch(name##_codes[name##_buffers - 1], k); \
    } \
  }
#include "grids.glsl"
#undef GRID

// `slot` is the brick's place in the 3D texture here, 10 bits an axis (see AtlasTextures).
vec4 filtered(sampler3D bricks, int slot, vec3 local) {
  ivec3 texel = ivec3(slot & 1023, (slot >> 10) & 1023, slot >> 20) * BRICK_VALUES;
  // a texel's centre is at +0.5; z is the fastest axis
  return textureLod(bricks, (vec3(texel) + local.zyx + 0.5) / vec3(textureSize(bricks, 0)), 0.0);
}

uvec4 fetch_code(int i) { return density_code(i); }

// A luminance beside the density is in its texels' further channels, but in textures of its own for the
// driver's filter and where the driver reads the host's memory.
vec4 fetch_pair(int i) {
  if (luminance_apart) return vec4(density_texel(i).x, luminance_texel(i).xyz);
  return density_texel(i);
}
bool is_beside(int grid) { return paired && !hardware_filter && grid == luminance_grid; }

uint fetch_page(int grid, int i) {
  return is_beside(grid) ? texelFetch(density_pages, i).x :
#define GRID(id, name) grid == id ? texelFetch(name##_pages, i).x :
#include "grids.glsl"
#undef GRID
      0u;
}

vec3 fetch_constant3(int grid, int i) {
  return is_beside(grid) ? texelFetch(density_constants, i).xyz :
#define GRID(id, name) grid == id ? texelFetch(name##_constants, i).xyz :
#include "grids.glsl"
#undef GRID
      vec3(0.0);
}
float fetch_constant(int grid, int i) { return fetch_constant3(grid, i).x; }

vec3 fetch_texel3(int grid, int i) {
  return is_beside(grid) ? fetch_pair(i).yzw :
#define GRID(id, name) grid == id ? name##_texel(i).xyz :
#include "grids.glsl"
#undef GRID
      vec3(0.0);
}
float fetch_texel(int grid, int i) { return fetch_texel3(grid, i).x; }

vec3 filtered_texel3(int grid, int slot, vec3 local) {
  return
#define GRID(id, name) grid == id ? filtered(name##_bricks, slot, local).xyz :
#include "grids.glsl"
#undef GRID
      vec3(0.0);
}
float filtered_texel(int grid, int slot, vec3 local) { return filtered_texel3(grid, slot, local).x; }
