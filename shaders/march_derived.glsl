// What follows from the constants a march is compiled for. They are constants too, not functions: a
// driver drops a branch on a constant before it inlines what the branch calls, one on a function's
// result after it, which made programs take 3 to 10 times as long to build. No include guard, as
// march_constants.glsl. A line each: compilers miscount those behind a longer one.
DERIVED(bool, constant_luminance, luminance_source == SOURCE_CONSTANT)
DERIVED(bool, own_luminance, luminance_source == SOURCE_SCALAR || luminance_source == SOURCE_VECTOR)
DERIVED(bool, beside_density, own_luminance && paired && !template_sampling)
DERIVED(bool, tracks_luminance, own_luminance && !beside_density && shows != SHOWS_surface)
DERIVED(bool, has_emission, emission_channels > 0)
DERIVED(bool, function_colors, luminance_source == SOURCE_TRANSFER || lit_colors)
DERIVED(bool, colored_luminance, luminance_source == SOURCE_VECTOR || function_colors)
DERIVED(bool, adds_glow, has_emission || others_shine)
DERIVED(bool, vector_radiance, colored_luminance || adds_glow)

DERIVED(bool, steps_along, uniform_sampling && !template_sampling)

// All that a segment looks up is in its middle: the walk follows the middles.
DERIVED(bool, walks_middles, uniform_sampling && middle_rule && !constant_runs && !brick_steps && !beyond)

// The picture depends on the optical depth alone, and that is the segment's own: no weights.
DERIVED(bool, integrates, shows == SHOWS_light || shows == SHOWS_depth)
DERIVED(bool, own_depth, exact_depth && !transfer_rule && !(transfer && cell_rule))
DERIVED(bool, depth_only, integrates && constant_luminance && !adds_glow && own_depth)

// Where nothing is stored the value is 0, and so is the attenuation unless a function says otherwise.
DERIVED(bool, vacuum_differs, transfer || beyond)

// A turn may end inside a cell.
DERIVED(bool, ends_pieces, cell_rule && !depth_only && (deep_cells || tracks_luminance || has_emission))
DERIVED(bool, limits_pieces, ends_pieces || other_volumes > 0)
DERIVED(bool, cuts_pieces, limits_pieces || (transfer && split_knots))

// Under cells the cubic's coefficients come straight from a cell's corners. Else its values do: a
// surface must not slip between two cells, and a maximum is a value.
DERIVED(bool, from_corners, (cell_rule || depth_only || transfer) && integrates && !hardware_filter)

// The next cell computes the value at its front from its own corners.
DERIVED(bool, front_is_free, from_corners && (nearest || cell_rule || (depth_only && !transfer)))

// A value of all that the ray passes, vacuum too.
DERIVED(bool, sees_all, mode == MODE_minip || mode == MODE_mean)

// The ray remembers a place: of a transmittance of 1/2, a maximum or a surface.
DERIVED(bool, keeps_depth, find_depth || !integrates)

// A piece between two knots has their function at its ends too: a jump's side that it lies on.
DERIVED(bool, keeps_interval, split_knots && !uniform_sampling)
