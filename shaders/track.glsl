// The ray in another grid than the density's.
struct Track {
  Ray ray;    // in its voxels
  Node node;  // that was read last
};

Track track_of(Pixel p, IN(Grid) g) {
  Ray ray = grid_ray(p, g);
  if (from_back) ray = reversed(ray);
  return Track(ray, no_node());
}

// The node of another grid that covers a cell.
Node seek_cell(int grid, int3 cell, Node node, int3 domain_min, int3 domain_max) {
  if (!inside(node, cell)) {
    node = empty_node(cell, 1);
    if (inside_box(domain_min, domain_max, cell)) node = find_node(grid, cell);
  }
  return node;
}

// The node of another grid at t.
Node seek_node(int grid, IN(Track) track, real t) {
  return seek_cell(grid, int3(floor(position(track.ray, t))), track.node, grid_of(grid).domain_min,
                   grid_of(grid).domain_max);
}

// What a look-up in a node adds to the count of samples.
int look_ups(Node node) { return count_steps && node.kind == NODE_BRICK ? 1 : 0; }

// Where the ray, from t on, next leaves a cell, a run or the domain of another grid.
real next_face(int grid, IN(Track) track, real t) {
  t += near_face;
  real face = NEVER;
  if (t < track.ray.begin) {
    face = track.ray.begin;
  } else if (t < track.ray.end) {
    // once: the node is that of this cell
    int3 cell = cell_between_faces(track.ray, t, int3(floor(position(track.ray, t))));
    Node node = seek_cell(grid, cell, track.node, grid_of(grid).domain_min, grid_of(grid).domain_max);
    bool brick = node.kind == NODE_BRICK;
    face = next_face_time(track.ray, brick ? cell : node.lo, brick ? 1 : node.side, t);
  }
  return face;
}

// The grid at t, in the node that was sought there.
real3 sample_grid(int grid, int channels, IN(Track) track, real t) {
  real3 v = real3(real(0.0));
  if (track.node.kind != NODE_EMPTY) {
    real3 p = position(track.ray, t);
    if (channels == 3) v = sample_vector(grid, track.node, p);
    else v = real3(sample_scalar(grid, track.node, p));
  }
  return v;
}

// The grid from t on, over a length in whose middle its node was sought.
Cubics track_cubics(int grid, int channels, IN(Track) track, real t, real length) {
  return cubics_along(grid, channels, track.node, position(track.ray, t), track.ray.direction * length);
}
