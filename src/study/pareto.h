#pragma once

#include <cstddef>
#include <vector>

namespace psivox {

struct Cost {
  double time = 0, error = 0;
};

/// Indices of the Pareto front, by time. A point joins the front if its error is less than (1 -
/// margin) times that of the cheaper points.
std::vector<std::size_t> pareto_front(const std::vector<Cost>& costs, double margin = 0);

}  // namespace psivox
