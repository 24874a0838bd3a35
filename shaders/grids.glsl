// The grids that the march reads: GRID(id, name). Each has the parameter `name` of the type Grid, the
// constants `name_levels` and `name_channels`, 0 where the medium has no such grid, and its textures.
// Those that emit come last. No include guard.
GRID(0, density)
GRID(1, luminance)
GRID(2, gradient)
GRID(3, others)  // of all further volumes
GRID(4, emission)
