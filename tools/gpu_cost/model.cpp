#include "model.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <vector>

namespace psivox::gpu_cost {

const std::vector<Card>& cards() {
  // NVIDIA's: code of navi21 in place of its own.
  static const std::vector<Card> list = {
      {"Radeon RX 6800 XT", "navi21", 72, 64, 4, 2.25e9},
      {"Radeon RX 7900 XTX", "gfx1100", 96, 64, 4, 2.5e9},
      {"GeForce RTX 3060", "navi21", 28, 128, 4, 1.78e9},
      {"GeForce RTX 4090", "navi21", 128, 128, 4, 2.52e9},
  };
  return list;
}

Prediction predict(const Card& card, const TurnCost& turn, const RayCounts& rays, double count) {
  const double turns = rays.wave_turns * count;
  const double clocks = double(card.units) * card.clock;
  Prediction p;
  p.arithmetic_ms = 1e3 * turns * turn.lane_clocks() / (clocks * card.lanes);
  p.fetch_ms = 1e3 * turns * turn.fetches / (clocks * card.fetches);
  p.look_ups_per_second = rays.look_ups * count / (1e-3 * p.ms());
  return p;
}

namespace {

/// Instructions from the first to before the last.
struct Range {
  std::size_t first = 0, last = 0;
  std::size_t size() const { return last - first; }
};

/// A program's instructions by name, and the loops among them.
struct Listing {
  std::vector<std::string> names;
  std::vector<Range> loops;  ///< each from its first label to the last jump to it
};

Listing read(const std::string& assembly) {
  Listing listing;
  std::map<std::string, std::size_t> labels;
  std::map<std::size_t, std::size_t> ends;  ///< of loops, by their first instruction
  std::istringstream lines(assembly);
  std::string line;
  while (std::getline(lines, line)) {
    if (line.starts_with("BB")) {
      labels[line.substr(0, line.find(':'))] = listing.names.size();
      continue;
    }
    std::istringstream words(line);
    std::string name, target;
    if (!(words >> name) || name.starts_with(";")) continue;
    words >> target;
    listing.names.push_back(name);
    if (!name.starts_with("s_branch") && !name.starts_with("s_cbranch")) continue;
    if (const auto label = labels.find(target); label != labels.end())
      ends[label->second] = listing.names.size();
  }
  for (const auto& [first, last] : ends) listing.loops.push_back({first, last});
  return listing;
}

/// The longest loop inside a range, apart from the range itself; empty: there is none.
Range longest_in(const Listing& listing, const Range& outer) {
  Range longest;
  for (const Range& loop : listing.loops)
    if (loop.first >= outer.first && loop.last <= outer.last && loop.size() < outer.size() &&
        loop.size() > longest.size())
      longest = loop;
  return longest;
}

bool starts_with_any(const std::string& name, std::initializer_list<const char*> prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(),
                     [&](const char* prefix) { return name.starts_with(prefix); });
}

}  // namespace

TurnCost turn_cost(const std::string& assembly) {
  const Listing listing = read(assembly);
  Range turn = longest_in(listing, {0, listing.names.size() + 1});
  if (const Range inner = longest_in(listing, turn); 2 * inner.size() > turn.size()) turn = inner;
  TurnCost cost;
  for (std::size_t i = turn.first; i < turn.last; ++i) {
    const std::string& name = listing.names[i];
    ++cost.instructions;
    if (name.starts_with("v_")) ++cost.vector;
    if (starts_with_any(name, {"v_rcp", "v_rsq", "v_sqrt", "v_exp", "v_log", "v_mul_lo", "v_mul_hi",
                               "v_mad_u64"}))
      ++cost.quarter;
    if (starts_with_any(name, {"buffer_load", "tbuffer_load", "image_"})) ++cost.fetches;
    if (starts_with_any(name, {"s_branch", "s_cbranch"})) ++cost.branches;
  }
  return cost;
}

}  // namespace psivox::gpu_cost
