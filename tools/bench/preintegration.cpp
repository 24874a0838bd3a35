// Measures the table of `preintegrated`: the process's CPU time [ms] to build it and to update it
// after a change of one control point, and its error bound.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>
#include <vector>

#include "bench.h"
#include "march/preintegration.h"
#include "psivox/stopwatch.h"

namespace {

using psivox::PreintegratedTable;
using psivox::TransferFunction;
using psivox::TransferPoint;
using psivox::bench::median;

template <typename Action>
double timed(const Action& action) {
  const psivox::Stopwatch watch;
  action();
  return watch.cpu_ms();
}

/// Evenly spaced points of random attenuation and colour.
TransferFunction random_function(int count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(0, 1);
  std::vector<TransferPoint> points;
  for (int i = 0; i < count; ++i)
    points.push_back({i / (count - 1.0), u(random), {u(random), u(random), u(random)}});
  return TransferFunction(points);
}

void measure(int count, double extinction, int layers) {
  const TransferFunction function = random_function(count);
  PreintegratedTable table(function, extinction, 1, {0, layers});
  std::vector<double> full, all, middle;
  for (int i = 0; i < 5; ++i)
    full.push_back(timed([&] { PreintegratedTable(function, extinction, 1, {0, layers}); }));
  const auto change = [&](int k) {
    std::vector<TransferPoint> points = function.points();
    points[std::size_t(k)].attenuation *= 0.9;
    points[std::size_t(k)].color.x *= 0.5;
    const TransferFunction changed(points);
    const double ms = timed([&] { table.update(changed); });
    table.update(function);
    return ms;
  };
  constexpr int places = 33;
  for (int i = 0; i < places; ++i) all.push_back(change(i * (count - 1) / (places - 1)));
  for (int i = 0; i < 5; ++i) middle.push_back(change(count / 2));
  const double whole = median(full);
  const double mean = std::accumulate(all.begin(), all.end(), 0.0) / places;
  std::printf(
      "%5d points, %4d x %4d x %2d, depth %-4g full %6.1f ms; one point: middle %5.1f (1/%.0f), "
      "mean %5.1f (1/%.0f), worst %5.1f (1/%.0f)\n",
      count, table.size(), table.size(), table.layers(), extinction, whole, median(middle),
      whole / median(middle), mean, whole / mean, *std::max_element(all.begin(), all.end()),
      whole / *std::max_element(all.begin(), all.end()));
}

/// Three functions: four smooth points; two tents a twentieth of the range wide; jumps.
void bounds() {
  const std::pair<const char*, TransferFunction> functions[] = {
      {"4 points",
       TransferFunction(
           {{0, 0, {0, 0, 1}}, {0.3, 0.2, {0, 1, 0}}, {0.7, 1, {1, 0.5, 0}}, {1, 0.4, {1, 1, 1}}})},
      {"2 tents", TransferFunction({{0, 0, {1, 0, 0}},
                                    {0.325, 0, {1, 0, 0}},
                                    {0.35, 1, {1, 0, 0}},
                                    {0.375, 0, {1, 0, 0}},
                                    {0.625, 0, {0, 0, 1}},
                                    {0.65, 1, {0, 0, 1}},
                                    {0.675, 0, {0, 0, 1}},
                                    {1, 0, {0, 0, 1}}})},
      {"jumps", TransferFunction({{0, 0.1, {0, 0, 1}},
                                  {0.4, 0, {0, 0, 1}},
                                  {0.4, 1, {1, 0, 0}},
                                  {0.6, 1, {1, 0, 0}},
                                  {0.6, 0.3, {0, 1, 0}},
                                  {1, 0.3, {0, 1, 0}}})},
      {"64 random", random_function(64)}};
  for (const auto& [name, function] : functions)
    for (const double depth : {0.1, 1.0, 10.0, 100.0}) {
      std::printf("%-9s depth %-4g bound", name, depth);
      for (const auto& [size, layers] : {std::pair{1025, 1}, {513, 4}, {257, 16}})
        std::printf("  %d x %d: %.1e", size, layers,
                    PreintegratedTable(function, depth, 1, {size, layers}).error_bound());
      std::printf("\n");
      std::fflush(stdout);
    }
}

}  // namespace

int main() {
  for (const double depth : {1.0, 100.0}) {
    measure(1024, depth, 1);
    measure(512, depth, 4);
    measure(256, depth, 16);
  }
  bounds();
}
