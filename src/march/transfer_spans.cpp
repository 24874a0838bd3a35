#include "march/transfer_spans.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace psivox {
namespace {

/// Gauss and Legendre's five points on [0, 1]: for depths up to 1 the relative error of the
/// weights is below 1e-10 (that of e^{-x} by this rule is x^10/10!/2.7e5).
constexpr double nodes[] = {0.046910077030668, 0.2307653449471584, 0.5, 0.7692346550528416,
                            0.953089922969332};
constexpr double node_weights[] = {0.1184634425280946, 0.2393143352496832, 0.2844444444444444,
                                   0.2393143352496832, 0.1184634425280946};

/// For a depth of 1 at most. Both weights are sums of what is not negative:
/// int u g' e^{-g} du of int g' e^{-g} du.
double thin_share(double x_front, double x_back) {
  double back = 0, sum = 0;
  for (int i = 0; i < 5; ++i) {
    const double u = nodes[i];
    const double x = x_front + (x_back - x_front) * u;
    const double depth = 0.5 * u * (x_front + x);
    const double w = node_weights[i] * x * std::exp(-depth);
    back += w * u;
    sum += w;
  }
  return sum > 0 ? back / sum : 0.5;
}

}  // namespace

SegmentView view_segment(double x_front, double x_back) {
  const double depth = 0.5 * (x_front + x_back);
  SegmentView view{-std::expm1(-depth), 0.5};
  if (depth <= 1) {
    view.back = thin_share(x_front, x_back);
    return view;
  }
  // parts of depth 1 from the front on, until nothing is seen
  const double slope = x_back - x_front;
  double u = 0, through = 1, back = 0, sum = 0;
  while (u < 1 && through > 1e-17) {
    const double x = x_front + slope * u;
    const double square = x * x + 2 * slope;
    double du = 1 - u;
    if (square >= 0) du = std::min(du, 2 / (x + std::sqrt(square)));
    const double x_end = x_front + slope * (u + du);
    const double w = through * -std::expm1(-0.5 * (x + x_end) * du);
    back += w * (u + du * thin_share(x * du, x_end * du));
    sum += w;
    through -= w;
    u = du < 1 - u ? u + du : 1;
  }
  view.back = back / sum;
  return view;
}

TransferLattice::TransferLattice(const TransferFunction& function, double first, double last,
                                 int intervals)
    : integrals_(std::size_t(intervals)) {
  const std::vector<TransferPoint>& points = function.points();
  const double spacing = (last - first) / intervals;
  auto next = std::upper_bound(points.begin(), points.end(), first,
                               [](double v, const TransferPoint& p) { return v < p.value; });
  TransferPoint from = function.at(first);
  for (int i = 0; i < intervals; ++i) {
    first_piece_.push_back(int(pieces_.size()));
    const double top = i + 1 == intervals ? last : first + spacing * (i + 1);
    Integral& integral = integrals_[std::size_t(i)];
    while (from.value < top) {
      const bool knot = next != points.end() && next->value < top;
      const TransferPoint to = knot ? *next++ : function.at(top);
      const double share = spacing > 0 ? (to.value - from.value) / spacing : 0;
      pieces_.push_back({share, {from.attenuation, to.attenuation}, {from.color, to.color}});
      integral.attenuation += share * 0.5 * (from.attenuation + to.attenuation);
      integral.source += (from.color * (2 * from.attenuation + to.attenuation) +
                          to.color * (from.attenuation + 2 * to.attenuation)) *
                         (share / 6);
      from = to;
    }
    if (next != points.end() && next->value == top) ++next;
  }
  first_piece_.push_back(int(pieces_.size()));
}

TransferRun TransferLattice::run(int interval, double length) const {
  TransferSpan sum;
  for (int i = first_piece_[std::size_t(interval)]; i < first_piece_[std::size_t(interval) + 1];
       ++i) {
    const Piece& p = pieces_[std::size_t(i)];
    const double x[] = {p.attenuation[0] * p.share * length, p.attenuation[1] * p.share * length};
    const SegmentView up = view_segment(x[0], x[1]), down = view_segment(x[1], x[0]);
    TransferSpan piece;
    piece.opacity = up.opacity;
    piece.up = glm::mix(p.color[0], p.color[1], up.back) * up.opacity;
    piece.down = glm::mix(p.color[1], p.color[0], down.back) * up.opacity;
    sum = join(sum, piece);
  }
  if (!(sum.opacity > 0)) return {};
  return {float(sum.opacity), sum.up / sum.opacity, sum.down / sum.opacity};
}

}  // namespace psivox
