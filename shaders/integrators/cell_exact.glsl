// The emission-absorption integral over a piece of a cell, where trilinear data is a cubic f(s):
//   C = integral of L tau e^{-g},  tau ds = x f(s) ds,  g its exact antiderivative (a quartic),
// by Gauss-Legendre quadrature in s, the weights normalised to 1 - zeta, so that constant L gives
// exactly L (1 - T). `through`: e^{-g} at s. Returns the weight of L there.
real cell_exact(Cubic c, real through, real s) { return evaluate(c, s) * through; }
