// The emission-absorption integral over a piece of a cell, where trilinear data is a cubic f(s):
//   C = integral of L tau e^{-g},  tau ds = x f(s) ds,  g its exact antiderivative (a quartic),
// by three-point Gauss-Legendre in s, the weights normalised to 1 - zeta, so that constant L gives
// exactly L (1 - T). A piece's optical depth is at most cell_piece_depth (docs/method.md); one that is
// deeper is as short as rounding, so that L is the same at all nodes.
// x: extinction times the piece's length. Returns the weights of L at the three nodes.
Weights cell_exact(Cubic c, real x) {
  real w_1 = real(5.0) * evaluate(c, cell_node_1) * shallow_decay(x * antiderivative(c, cell_node_1));
  real w_2 = real(8.0) * evaluate(c, real(0.5)) * shallow_decay(x * antiderivative(c, real(0.5)));
  real w_3 = real(5.0) * evaluate(c, cell_node_3) * shallow_decay(x * antiderivative(c, cell_node_3));
  real depth = max(x * antiderivative(c, real(1.0)), real(0.0));
  real scale = decay(depth).a / max(w_1 + w_2 + w_3, real(1e-30));
  return Weights(w_1 * scale, w_2 * scale, w_3 * scale, depth);
}
