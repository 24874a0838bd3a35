#include "march/light_slabs.h"

#include <algorithm>
#include <functional>
#include <map>

namespace psivox {
namespace {

/// Octants of the density's bricks that hide nothing, a bit each; empty where they are not known.
std::vector<std::uint8_t> dark_octants(const BrickAtlas& density) {
  if (!density.own_texels || !density.pages.octants) return {};
  std::vector<std::uint8_t> dark(density.places.size());
  for (const std::uint32_t entry : density.pages.entries)
    if (entry_kind(entry) == EntryKind::brick)
      dark[density.pages.slot(entry)] = std::uint8_t(~(entry_payload(entry) >> entry_slot_bits));
  return dark;
}

}  // namespace

LightSlabs::LightSlabs(const LatticeFrame& frame, const LightBlocks& blocks) {
  std::map<int, LightSlab> slabs;
  const auto slab_of = [&](std::size_t i) -> LightSlab& {
    const int z = blocks.all[i][frame.axis];
    return slabs[std::min(frame.slice(z), frame.slice(z + 7))];
  };
  for (std::size_t i = 0; i < blocks.all.size(); ++i) slab_of(i).blocks.push_back(std::uint32_t(i));
  for (const std::size_t i : blocks.wanted) slab_of(i).wanted.push_back(std::uint32_t(i));
  for (auto& [first_slice, slab] : slabs) {
    slab.first_slice = first_slice;
    std::ranges::stable_sort(slab.wanted, std::less{},
                             [&](std::uint32_t i) { return blocks.all[i][frame.axis_u]; });
    slabs_.push_back(std::move(slab));
  }
}

void LightSlabs::add_octants(const LatticeFrame& frame, const BrickAtlas& density, int begin,
                             int end) {
  const auto slab_from = [&](int slice) {
    return std::ranges::lower_bound(slabs_, slice, std::less{}, &LightSlab::first_slice);
  };
  const std::vector<std::uint8_t> dark = dark_octants(density);
  for (std::size_t k = 0; k < dark.size(); ++k)
    for (int i = 0; i < 8; ++i) {
      if (!(dark[k] >> i & 1)) continue;
      const glm::ivec3 corner =
          brick_cells * density.places[k] + 4 * glm::ivec3(i >> 2, i >> 1 & 1, i & 1);
      const int z = corner[frame.axis], slice = std::min(frame.slice(z), frame.slice(z + 4));
      // a cell between two slices belongs to the second
      for (int first = std::max((slice + 1) & ~7, begin); first <= slice + 4 && first < end;
           first += 8)
        if (const auto slab = slab_from(first); slab != slabs_.end() && slab->first_slice == first)
          slab->octants.push_back({corner, slice});
    }
}

void LightSlabs::drop_octants() {
  for (LightSlab& slab : slabs_) slab.octants = {};
}

}  // namespace psivox
