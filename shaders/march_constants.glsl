// What a shader is compiled for: constants in GLSL, so that terms which cannot change the picture
// vanish; plain members in the march in double. No include guard, as march_parameters.glsl.
CONSTANT(int, mode)               // Mode
CONSTANT(int, shows)              // Shows, what the mode shows of a ray
CONSTANT(bool, from_back)         // rays are marched back to front
CONSTANT(bool, veils)             // a surface is not opaque
CONSTANT(int, luminance_source)   // LuminanceSource
CONSTANT(bool, octants)           // rays pass over octants of bricks that their entries say are hidden
CONSTANT(bool, absent_voxels)     // some of the density's values are NaN: a cell with one is vacuum
CONSTANT(bool, nearest)           // voxels are cells of one value
CONSTANT(bool, lit_voxels)        // and so are those of the luminance, which is light
CONSTANT(bool, coded)             // the density's bricks are codes
CONSTANT(int, one_width)          // CodeWidth of all of them; -1: not the same
CONSTANT(bool, paired)            // luminance is stored beside the density, in the same bricks
CONSTANT(int, other_volumes)      // grids of further volumes, see others.glsl
CONSTANT(bool, others_shine)      // they have luminance or emission, else they attenuate alone
CONSTANT(bool, attenuates)        // the extinction is not 0
CONSTANT(bool, ends_early)        // a ray may become opaque
CONSTANT(bool, transfer)          // a transfer function classifies values; else tau ~ value
CONSTANT(bool, one_interval)      // which has two knots: nothing is searched
CONSTANT(bool, lit_colors)        // and its colours, in light: the luminance's grid has the light alone
CONSTANT(bool, transfer_search)   // several of its knots may lie in one bin of its table
CONSTANT(bool, ramps)             // whose attenuation is a sum of ramps, and nothing asks for colours
CONSTANT(bool, with_gradient)     // and the gradient's magnitude, a grid of its own
CONSTANT(bool, in_part)           // only a region is marched: cells beside it may have values
CONSTANT(bool, beyond)            // the walk goes beyond the density, where 0 would be a medium
CONSTANT(bool, split_knots)       // segments end where the value crosses its knots
CONSTANT(int, segments)           // linear segments a cell
#define GRID(id, name) CONSTANT(int, name##_levels) CONSTANT(int, name##_channels)
#include "grids.glsl"
#undef GRID
CONSTANT(bool, constant_runs)     // the density atlas has constant entries
CONSTANT(bool, uniform_sampling)  // between samples, not cells
CONSTANT(bool, brick_steps)       // each brick has a step of its own
CONSTANT(bool, template_sampling) // the samples are the voxels of a template
CONSTANT(bool, middle_rule)       // the integrator reads middles, not ends
CONSTANT(bool, exact_depth)       // the integrator takes the segment's depth, not its own
CONSTANT(bool, cell_rule)         // the integrator takes a cell's cubic, not segments
CONSTANT(int, cell_nodes)         // in which it reads the luminance: 4, 6 or 8
CONSTANT(bool, deep_cells)        // a cell may be deeper than it takes at a time
CONSTANT(bool, great_values)      // its sums need node_unit to stay within a float
CONSTANT(bool, transfer_rule)     // the integrator takes values and applies the function itself
CONSTANT(bool, end_corrections)   // psi-balanced, and a ray may begin or end inside the medium
CONSTANT(bool, hardware_filter)
CONSTANT(bool, orthographic)
CONSTANT(bool, clips)             // planes cut rays off
CONSTANT(bool, holds_out)         // each pixel has a depth at which its rays end
CONSTANT(bool, anisotropic)       // the luminance has a phase, a factor of the ray's direction
CONSTANT(bool, count_steps)
CONSTANT(bool, has_passed)        // in_part: what rays have passed before is known
CONSTANT(bool, find_depth)
