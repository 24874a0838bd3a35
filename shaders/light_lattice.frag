#include "marcher.glsl"
#include "light_lattice.glsl"

// A row is 32 bricks of the lattice; entry bricks_first + 32 row + k of `tables` has the first column's
// two numbers and the first slice of the k-th, whose 16 columns follow each other.
uniform int bricks_first;

layout(location = 0) out vec4 out_picture;  // depths at the brick's first four slices
layout(location = 1) out vec4 out_layers;   // and at its last four

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 brick = fetch_table(bricks_first + 32 * at.y + (at.x >> 4));
  ColumnDepths depths = column_depths(vec2(brick.x + float((at.x >> 2) & 3),
                                           brick.y + float(at.x & 3)), brick.z);
  out_picture = depths.first;
  out_layers = depths.last;
}
