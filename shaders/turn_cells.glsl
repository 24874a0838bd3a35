// Cells: a turn crosses one stretch of the ray.

// What a walk in cells keeps of its last node, if that holds the next cell: not the node's first cell, which
// follows from the ray's.
struct CellWalk {
  int kind;
  int payload;
  int side;  // 0: nothing is kept
};

CellWalk begin_cells() { return CellWalk(NODE_EMPTY, 0, 0); }

void turn_cells(INOUT(March) m, INOUT(CellWalk) w, Ray ray) {
  Node node = Node(w.kind, w.payload, m.cell, w.side);  // its first cell counts in runs alone
  if (w.side == 0) node = find_node(density_grid, m.cell);
  node = with_data(node, m.cell);
  Stretch s = find_stretch(m, node, ray);
  m.paired_here = false;
  if (node.kind == NODE_BRICK) {
    sample_stretch(s, m, node, ray);
    m.samples += look_ups(node);
  }
  if (!front_is_free && !s.run && !m.known) find_front(s, m);
  if (!from_corners) s.value = make_cubic(s.f_front, s.f_half, s.f_end, s.q_3);
  if (!m.vacuum) seek_gradient(m, m.cell);
  s.slope = gradient_along(m, ray, s.extent);
  classify_stretch(s, m);
  m.front = with_value(m, m.front, Sample(s.f_front, max(s.slope.f_0, real(0.0))));
  if (limits_pieces && (!s.run || other_volumes > 0)) limit_piece(s, m, ray);
  if (cuts_pieces) cut_piece(s, m);
  cross_cell(m, node, s, ray);
  bool crossed = !cuts_pieces || m.t >= s.t_exit;
  if (crossed) m.cell = s.next;
  w = CellWalk(node.kind, node.payload, s.run || (crossed && s.leaves) ? 0 : node.side);
  // a brick without the isovalue is empty too, whatever its values, and so is what lies beside a region
  m.known = !((shows == SHOWS_surface || in_part || absent_voxels) && m.vacuum);
  if (!m.known) m.front.value = UNKNOWN;
}
