#pragma once

#include <string>
#include <vector>

#include "programs.h"
#include "turn_cost.h"

namespace psivox::gpu_cost {

/// A GPU as the model sees it.
struct Card {
  std::string name;
  std::string family;  ///< of RADV, whose code is counted
  int units = 0;       ///< compute units, or multiprocessors
  int lanes = 0;       ///< float32 instructions of a unit a clock
  int fetches = 0;     ///< texels of a unit a clock
  double clock = 0;    ///< [Hz]
};

const std::vector<Card>& cards();

/// What bounds a picture on a card. The prediction is the larger of the two: where neither waits
/// for the other a GPU does both at a time.
struct Prediction {
  double arithmetic_ms = 0;
  double fetch_ms = 0;
  double look_ups_per_second = 0;
  double ms() const { return arithmetic_ms > fetch_ms ? arithmetic_ms : fetch_ms; }
};

/// Of a picture of so many rays, whose waves execute every instruction of every turn.
Prediction predict(const Card& card, const TurnCost& turn, const RayCounts& rays, double count);

}  // namespace psivox::gpu_cost
