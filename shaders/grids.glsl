// The grids that the march reads: GRID(id, name), the name as in MediumAtlas. Each has the parameter
// `name` of the type Grid, the constant `name_levels`, and its textures. No include guard.
GRID(0, density)
GRID(1, luminance)
GRID(2, emission)
GRID(3, gradient)
GRID(4, others)  // of all further volumes
