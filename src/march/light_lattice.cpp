#include "march/light_lattice.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>

#include "atlas/atlas.h"
#include "field/index_space.h"

namespace psivox {

LatticeFrame::LatticeFrame(const View& view, const Box& box, const Beam& beam)
    : domain(box), spacing(beam.method.spacing) {
  const Medium& medium = view.medium;
  const glm::dvec3 towards(glm::inverse(glm::dmat3(medium.density->world_from_index)) *
                           -beam.direction);
  const glm::dvec3 size = glm::abs(towards);
  axis = longest_axis(size);
  axis_u = axis == 0 ? 1 : 0;
  axis_v = axis == 2 ? 1 : 2;
  side = towards[axis] > 0 ? 1 : -1;
  first = side > 0 ? domain.max[axis] | 7 : domain.min[axis] & ~7;
  shear = glm::dvec2(towards[axis_u], towards[axis_v]) / size[axis];
  origin = glm::dvec2(across(domain.min));
  length = 1 / size[axis];
  end = -std::log(beam.method.termination);
}

DarkCells::DarkCells(const LatticeFrame& frame, const MediumAtlas& atlas) {
  const PageTable& pages = atlas.density.pages;
  // What lies on a part's face also weighs in the step beside it, which may be of another slab.
  // Beside the whole nothing attenuates.
  const int beside = atlas.part ? 1 : 0;
  const auto add = [&](const CellCube& cube) {
    const int z = cube.corner[frame.axis];
    const int slice = std::min(frame.slice(z), frame.slice(z + cube.width));
    // a cell between two slices belongs to the second
    const int from = std::max((slice + 1 - beside) >> 3, 0);
    const int to = std::min((slice + cube.width + beside) >> 3, frame.slabs() - 1);
    for (int slab = from; slab <= to; ++slab) slabs_[slab].push_back(cube);
  };
  for_entries(pages, [&](std::uint32_t entry, const glm::ivec3& first, int width) {
    const glm::ivec3 corner = pages.min + brick_cells * first;
    const bool is_brick = entry_kind(entry) == EntryKind::brick;
    if (!is_brick && atlas.density.own_texels) return;  // a constant of 0, which hides nothing
    if (!is_brick || !pages.octants) return add({corner, brick_cells * width});
    const std::uint32_t hidden = entry_payload(entry) >> entry_slot_bits;
    for (int i = 0; i < 8; ++i)
      if (!(hidden >> i & 1)) add({corner + 4 * cube_corner(i), 4});
  });
}

void lattice_depths(const LatticeFrame& frame, const MediumAtlas& atlas, LightBlocks blocks,
                    const LatticeColumns& columns, const TakeDepths& take, const Progress& progress,
                    const glm::dmat4* to_index) {
  const DarkCells dark(frame, atlas);
  LatticeRun run(frame, blocks, take, to_index);
  for (int slab = 0; (slab = run.next_slab(slab, dark)) >= 0; ++slab) {
    run.add(slab, dark, columns);
    run.finish(slab);
    if (progress) progress(double(slab + 1) / double(frame.slabs()));
  }
}

}  // namespace psivox
