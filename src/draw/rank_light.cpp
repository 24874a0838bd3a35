#include "draw/rank_light.h"

#include <algorithm>
#include <mutex>
#include <numeric>
#include <utility>

namespace psivox {
namespace {

/// A block of depths as it is sent: its number, then 512 depths.
constexpr std::size_t sent_block = 1 + 512 / 4;

using Message = std::vector<glm::vec4>;

/// Sends a message to one rank. Returns what another sends to this one.
Message pass_on(Team& team, Message message, int to, int from) {
  std::vector<Message> all(std::size_t(team.size()));
  all[std::size_t(to)] = std::move(message);
  return team.exchange(all)[std::size_t(from)];
}

/// Places in space of the wanted blocks; their coordinates are whole numbers below 2^24.
Message places_of(const LightBlocks& blocks) {
  Message places;
  places.reserve(blocks.wanted.size());
  for (const std::size_t block : blocks.wanted)
    places.emplace_back(glm::vec3(blocks.all[block]), 0);
  return places;
}

/// Depths of this rank's part towards blocks of another. Those that it does not hide are left out.
Message depths_towards(const LightDepths& own, const Beam& beam, const Message& places,
                       const Progress& progress) {
  std::vector<glm::ivec3> all;
  for (const glm::vec4& place : places) all.emplace_back(place.x, place.y, place.z);
  std::vector<std::size_t> wanted(all.size());
  std::iota(wanted.begin(), wanted.end(), std::size_t{0});
  Message found;
  std::mutex finding;
  const TakeLight take = [&](std::size_t, std::size_t block, std::span<const double> depths) {
    if (std::ranges::all_of(depths, [](double depth) { return depth == 0; })) return;
    const std::lock_guard lock(finding);
    found.emplace_back(glm::vec3(0), float(block));
    for (std::size_t i = 0; i < 512; i += 4)
      found.emplace_back(depths[i], depths[i + 1], depths[i + 2], depths[i + 3]);
  };
  own({&beam, 1}, {all, wanted}, take, progress);
  return found;
}

}  // namespace

BeamDepths joined_depths(Team& team, LightDepths own) {
  return [&team, own = std::move(own)](const Beam& beam, const LightBlocks& blocks,
                                       const TakeDepths& take, const Progress& progress) {
    const int count = team.size(), rank = team.rank();
    const Message places = places_of(blocks);
    std::vector<double> sums(512 * places.size());
    // in each turn all work, each for another
    for (int turn = 0; turn < count; ++turn) {
      const int served = (rank + turn) % count, serving = (rank + count - turn) % count;
      const Message theirs = pass_on(team, places, serving, served);
      const Message found = depths_towards(own, beam, theirs, [&](double done) {
        if (progress) progress((turn + done) / count);
      });
      const Message received = pass_on(team, found, served, serving);
      for (std::size_t at = 0; at < received.size(); at += sent_block) {
        double* sum = sums.data() + 512 * std::size_t(received[at].w);
        for (std::size_t i = 0; i < 512; ++i)
          sum[i] += double(received[at + 1 + i / 4][int(i % 4)]);
      }
    }
    for (std::size_t i = 0; i < places.size(); ++i)
      take(blocks.wanted[i], std::span<const double>(sums).subspan(512 * i, 512));
  };
}

}  // namespace psivox
