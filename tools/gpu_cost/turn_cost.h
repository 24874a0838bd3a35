#pragma once

#include <string>

namespace psivox::gpu_cost {

/// Instructions that a wave executes in one turn of the march's loop if it skips none.
struct TurnCost {
  int instructions = 0;  ///< of all kinds
  int vector = 0;        ///< arithmetic of all lanes
  int quarter = 0;       ///< those of `vector` that run at a quarter of the rate
  int fetches = 0;       ///< of texels, page table entries and tables
  int branches = 0;

  /// Clocks that a SIMD lane computes.
  int lane_clocks() const { return vector + 3 * quarter; }
};

/// Reads the turn off a program's assembly, as LLVM prints it. The march is a loop around a loop of
/// 16 turns, and the turn is the body of the inner one; where the outermost loop holds none that is
/// as long as half of it, the turn is its own body. All 0 of a program without loops.
TurnCost turn_cost(const std::string& assembly);

}  // namespace psivox::gpu_cost
