// What stands before a shader that src/gl/webgl_march.h writes for WebGL 2.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
precision highp sampler3D;

// WebGL has no texture buffers: their entries are the texels of a texture, row by row.
const int row_bits = 12;
vec4 entry_of(sampler2D rows, int i) {
  return texelFetch(rows, ivec2(i & ((1 << row_bits) - 1), i >> row_bits), 0);
}
uvec4 entry_of(usampler2D rows, int i) {
  return texelFetch(rows, ivec2(i & ((1 << row_bits) - 1), i >> row_bits), 0);
}

// It has no `precise`. No compiler fuses a product with a sum across bits that it cannot know.
uniform int no_bits;  // 0
float exactly(float v) { return intBitsToFloat(floatBitsToInt(v) ^ no_bits); }
