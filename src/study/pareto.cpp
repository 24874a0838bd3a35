#include "study/pareto.h"

#include <algorithm>
#include <numeric>

namespace psivox {

std::vector<std::size_t> pareto_front(const std::vector<Cost>& costs, double margin) {
  std::vector<std::size_t> order(costs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return costs[a].time != costs[b].time ? costs[a].time < costs[b].time
                                          : costs[a].error < costs[b].error;
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order)
    if (front.empty() || costs[i].error < (1 - margin) * costs[front.back()].error)
      front.push_back(i);
  return front;
}

}  // namespace psivox
