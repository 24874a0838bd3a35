// Every number that the march reads, once: expanded as GLSL uniforms, as members of the march in
// double, and as the code that sets the ones from the others. No include guard: expanded thrice.
//
// Coordinates are voxels of a grid relative to a voxel near the middle of its domain; t counts the
// finest voxel's length in the world, so that optical depths and positions are of one size whatever
// the transform's scale (see RayBundle in camera.h, whose affine functions these are).
#define GRID(id, name) PARAMETER(Grid, name)
#include "grids.glsl"
#undef GRID
PARAMETER(int3, density_field_min)    // domain of the density's own field: another grid may have
PARAMETER(int3, density_field_max)    // widened that of the atlas
PARAMETER(int3, part_min)             // in_part: the region that the ray collects from, to the
PARAMETER(int3, part_max)             // cells before this
PARAMETER(int, passed_first)          // has_passed: where `tables` has what rays have passed, see
PARAMETER(int, passed_x)              // RenderOptions::passed, four an entry, row by row; of the
PARAMETER(int, passed_y)              // first one the pixel
PARAMETER(int, passed_width)          // [pixels]
PARAMETER(real3, world_0)             // world direction, not normalised
PARAMETER(real3, world_u)
PARAMETER(real3, world_v)
PARAMETER(real, camera_distance)      // of the anchor plane [unit of t]
PARAMETER(real2, image_size)          // [pixels]
PARAMETER(real2, sample_offset)       // of the sample inside its pixel
PARAMETER(real, extinction)           // attenuation of value 1 [1 / unit of t]
PARAMETER(real3, color)               // factor of the luminance
PARAMETER(real3, ambient)             // luminance that is added to it everywhere
PARAMETER(real, stop_depth)           // optical depth at which a ray ends
PARAMETER(real, piece_depth)          // largest of a piece of a cell, where cells are cut
PARAMETER(real, node_unit)            // of the nodes' weights, a power of 2
PARAMETER(real, step)                 // of the uniform lattice [unit of t]
PARAMETER(int, brick_steps_first)     // where `tables` has the bricks' parts of the step
PARAMETER(real, opacity_unit)         // length of which opacity_linear's opacities are [unit of t]
PARAMETER(int, psi_table_first)       // of psi_table's entries among the tables
PARAMETER(real, world_unit)           // world length of one unit of t
PARAMETER(int, max_turns)             // of the loop in this pass
PARAMETER(real, lmip_threshold)
PARAMETER(real, least_value)  // maxima no nearer to 0 show something, and so much is a fall
PARAMETER(int, surfaces_first)        // where `tables` has the surfaces by ascending values: the value, then
PARAMETER(int, surfaces)              // colour and opacity
PARAMETER(real, first_isovalue)
PARAMETER(real, last_isovalue)
PARAMETER(real3, normal_x)            // columns of the inverse transposed transform: what turns a
PARAMETER(real3, normal_y)            // gradient over voxels into the world's [1 / unit of t]
PARAMETER(real3, normal_z)
PARAMETER(int, surface_lights_first)  // where `tables` has the lights of surfaces: direction, colour
PARAMETER(int, surface_lights)        // 0: one from the camera
PARAMETER(real3, phase_axis)          // along which the light travels whose scattering is seen
PARAMETER(real, phase_g)              // mean cosine of that scattering
PARAMETER(int, transfer_first)        // where `tables` has the transfer function, see transfer.glsl
PARAMETER(int, transfer_knots)
PARAMETER(int, transfer_bins_first)
PARAMETER(int, transfer_bins)
PARAMETER(real, transfer_min)
PARAMETER(real, transfer_bin_scale)
PARAMETER(real, ramp_base)            // its attenuation where `ramps`, see transfer.glsl
PARAMETER(real4, ramp_knots)
PARAMETER(real4, ramp_slopes)
PARAMETER(int, gradient_first)        // where `tables` has the function's gradient part, see
PARAMETER(int, gradient_columns)      // src/march/transfer_table.h
PARAMETER(int, isosurfaces_first)
PARAMETER(int, isosurfaces)
PARAMETER(int, clip_first)            // where `tables` has the clip's planes, four entries each
PARAMETER(int, clip_planes)
PARAMETER(int, held_first)            // where `tables` has the depths at which rays end, of all pixels
PARAMETER(int, held_width)            // row by row, four an entry, from the anchor plane along the view
PARAMETER(int, others_first)          // where `tables` has the further volumes, see others.glsl
PARAMETER(int, template_first)        // where `tables` has the ray template
PARAMETER(int, template_entries)
PARAMETER(int, template_axis)         // of the base plane
PARAMETER(real, template_spacing)     // mean distance of its voxels along the ray [unit of t]
PARAMETER(int, preintegration_first)  // the table of `preintegrated`, see src/march/preintegration.h
PARAMETER(int, preintegration_size)   // values along each axis
PARAMETER(int, preintegration_layers)
PARAMETER(real, preintegration_scale)   // entries per unit of value
PARAMETER(real, preintegration_length)  // of the last layer [unit of t]
