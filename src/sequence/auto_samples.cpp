#include <algorithm>
#include <optional>
#include <set>

#include "look/flame.h"
#include "psivox/error.h"
#include "psivox/sequence.h"

namespace psivox {
namespace {

/// Files that are looked at for a flame.
constexpr std::size_t most_surveyed = 64;

/// Voxels that burn; unset if the file has no grid of a flame, or cannot be read.
std::optional<std::uint64_t> burning_voxels(const std::string& path) {
  try {
    const VdbFile file(path);
    for (const char* name : flame_names(/*hot=*/false)) {
      if (file.channels(name) != 1) continue;
      const GridContent content = file.content(name);
      return content.nothing.empty() ? content.active_voxels : 0;
    }
  } catch (const Error&) {  // drawing it will say why
  }
  return {};
}

}  // namespace

std::vector<std::string> auto_samples(const SequenceFiles& files) {
  std::vector<std::string> paths;
  for (const auto& [frame, path] : files) paths.push_back(path);
  std::set<std::size_t> samples{0, paths.size() / 2, paths.size() - 1};
  const bool may_burn = std::ranges::any_of(
      samples, [&](std::size_t n) { return burning_voxels(paths[n]).has_value(); });
  if (may_burn && paths.size() > samples.size()) {
    std::size_t most = 0;
    std::uint64_t voxels = 0;
    const std::size_t count = std::min(paths.size(), most_surveyed);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t n = count == 1 ? 0 : i * (paths.size() - 1) / (count - 1);
      if (const std::uint64_t burning = burning_voxels(paths[n]).value_or(0); burning > voxels) {
        voxels = burning;
        most = n;
      }
    }
    if (voxels > 0) samples.insert(most);
  }
  std::vector<std::string> chosen;
  for (const std::size_t n : samples) chosen.push_back(paths[n]);
  return chosen;
}

}  // namespace psivox
