#pragma once

#include <string>
#include <vector>

#include "programs.h"

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

/// Instructions that a wave executes in one turn of the march's loop if it skips none.
struct TurnCost {
  int instructions = 0;  ///< of all kinds
  int vector = 0;        ///< arithmetic of all lanes
  int quarter = 0;       ///< part of `vector` that runs at a quarter of the rate
  int fetches = 0;       ///< of texels, page table entries and tables
  int branches = 0;

  /// Clocks that a SIMD lane computes.
  int lane_clocks() const { return vector + 3 * quarter; }
};

/// Reads the turn off a program's assembly, as LLVM prints it. The march is a loop around a loop of
/// 16 turns, and the turn is the body of the inner one; where the outermost loop holds none that is
/// as long as half of it, the turn is its own body. All 0 of a program without loops.
TurnCost turn_cost(const std::string& assembly);

/// What bounds a picture on a card. The prediction is the larger of the two: where neither waits
/// for the other a GPU does both at a time.
struct Prediction {
  double arithmetic_ms = 0;
  double fetch_ms = 0;
  double look_ups_per_second = 0;
  double ms() const { return arithmetic_ms > fetch_ms ? arithmetic_ms : fetch_ms; }
};

/// Predicts a picture of `count` rays whose waves execute every instruction of every turn.
Prediction predict(const Card& card, const TurnCost& turn, const RayCounts& rays, double count);

}  // namespace psivox::gpu_cost
