// The numbers of one grid that the march reads. No include guard, as march_parameters.glsl.
PARAMETER(real3, anchor_0)     // the ray of a pixel in the grid's voxels (RayBundle in camera.h)
PARAMETER(real3, anchor_u)
PARAMETER(real3, anchor_v)
PARAMETER(real3, direction_0)
PARAMETER(real3, direction_u)
PARAMETER(real3, direction_v)
PARAMETER(int3, domain_min)    // first voxel of the domain
PARAMETER(int3, domain_max)    // last voxel of the domain
PARAMETER(int3, table_min)     // first voxel of the page table
PARAMETER(int3, table_size)    // entries of the top table
PARAMETER(real, scale)         // emission of value 1, if it emits [radiance / unit of t]
