// What rules may look up: rays in voxels, the atlas, the transfer function.
#include "ray.glsl"
#include "atlas.glsl"
#include "samples.glsl"
#include "others.glsl"
#include "transfer.glsl"
