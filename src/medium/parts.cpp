#include "psivox/medium.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/memory.h"
#include "base/text.h"
#include "scene/enum_names.h"

namespace psivox {
namespace {

/// What psivox takes without grids, most of it the code of libraries and Mesa's software driver
/// with its compiler, and what a picture in parts takes on host and GPU for each pixel [bytes].
/// Measured; see docs/performance.md.
constexpr std::uint64_t of_program = 168 << 20, of_pixel = 80;
/// Grids may take this much under any limit that is as large [bytes].
constexpr std::uint64_t least = 32 << 20;

/// The modes in which a volume can be drawn in parts, for a message.
std::string modes_in_parts() {
  const std::vector<std::string> all = enum_names(Mode{});
  std::vector<std::string> names;
  for (const ModeInfo& row : mode_rows)
    if (row.in_parts) names.push_back(all[std::size_t(row.id)]);
  const std::string last = names.back();
  names.pop_back();
  return joined(names, ", ") + " and " + last;
}

}  // namespace

std::string parts_obstacle(const Scene& scene) {
  if (!info(scene.mode).in_parts) return "--mode " + modes_in_parts();
  if (scene.resolved_sampling() == Sampling::template_) return "--sampling cells and uniform";
  if (!scene.volumes.empty()) return "volumes without --and";
  return {};
}

std::uint64_t grid_memory(const Scene& scene) {
  const std::uint64_t limit = scene.memory_limit;
  if (limit == 0) return available_memory() / 5 * 4;
  const auto pixels = std::uint64_t(scene.resolution.x) * std::uint64_t(scene.resolution.y);
  const std::uint64_t others = of_program + of_pixel * pixels;
  return std::max(limit > others ? limit - others : 0, std::min(limit, least));
}

}  // namespace psivox
