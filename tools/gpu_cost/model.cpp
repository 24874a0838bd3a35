#include "model.h"

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

}  // namespace psivox::gpu_cost
