// Cells: a turn crosses one stretch of the ray.
void turn_cells(INOUT(March) m, INOUT(Node) node, Ray ray) {
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
  cross_cell(m, node, s);
  if (!cuts_pieces || m.t >= s.t_exit) m.cell = s.next;
  // a brick without the isovalue is empty too, whatever its values, and so is what lies beside a region
  m.known = !((shows == SHOWS_surface || in_part) && m.vacuum);
  if (!m.known) m.front.value = UNKNOWN;
}
