#include "sequence/film_places.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <utility>

#include "field/index_space.h"
#include "medium/map_field.h"
#include "psivox/error.h"

namespace psivox {
namespace {

/// What places a file's world in the scene's.
glm::dmat4 node_placement(Scene scene) {
  scene.centering = Centering::node;
  return placement(scene, glm::dmat4(1));
}

/// The most files whose headers are read: of more, a part.
constexpr std::size_t most_headers = 4096;

/// World bounds of a box that is placed in a scene.
std::pair<glm::dvec3, glm::dvec3> placed_box(const glm::dmat4& m, const GridPlace& place) {
  return bounds_of({glm::ivec3(0), glm::ivec3(1)}, [&](const glm::dvec3& part) {
    return glm::dvec3(m * glm::dvec4(glm::mix(place.world_min, place.world_max, part), 1));
  });
}

}  // namespace

GridPlace density_place(const Scene& scene, const VolumeFile& file) {
  const std::string grid = scene.grid.empty() ? file.default_grid(/*empty=*/true) : scene.grid;
  return file.place(vector_part(file, grid).grid);
}

std::vector<FilePlace> places_of(const Scene& scene, std::span<const std::string> files) {
  std::vector<FilePlace> places;
  const std::size_t step = 1 + files.size() / most_headers;
  for (std::size_t n = 0; n < files.size(); n += step) try {
      if (!frame_of_file(files[n]).frame.empty()) continue;  // of a scan, which tells nothing
      places.push_back({files[n], density_place(scene, VolumeFile(files[n]))});
    } catch (const Error&) {  // drawing it will say why
    }
  return places;
}

std::optional<AdaptiveDomain> adaptive_domain(const std::vector<FilePlace>& places) {
  constexpr double rounding = 1e-3;
  const auto width = [](const GridPlace& place) {
    const glm::ivec3& n = place.domain;
    return place.voxel_size * std::max({n.x, n.y, n.z});
  };
  const GridPlace* finest = nullptr;
  bool same = true;
  for (const auto& [path, place] : places) {
    if (!(width(place) > 0)) continue;
    if (finest && std::abs(width(place) - width(*finest)) > rounding * width(*finest)) return {};
    same &= !finest || place.domain == finest->domain;
    if (!finest || place.voxel_size < finest->voxel_size) finest = &place;
  }
  if (same) return {};
  const glm::dvec3 size = finest->voxel_size * glm::dvec3(finest->domain);
  return AdaptiveDomain{finest->voxel_size, {size.x / 2, size.y / 2, 0}};
}

std::vector<std::string> far_files(const Scene& scene, const std::vector<FilePlace>& places,
                                   std::span<const std::string> shown,
                                   const std::optional<AdaptiveDomain>& adaptive) {
  std::vector<std::string> far;
  for (int axis = 0; axis < 3; ++axis)
    for (const int sign : {-1, 1}) {
      double least = HUGE_VAL, most = -HUGE_VAL, most_shown = -HUGE_VAL;
      const std::string* farthest = nullptr;
      for (const auto& [path, place] : places) {
        if (!place.known || place.voxels == 0) continue;
        const Scene own = adaptive ? adaptive->placed(scene, place) : scene;
        const auto [low, high] = placed_box(node_placement(own), place);
        const double reach = sign * (sign < 0 ? low : high)[axis];
        least = std::min(least, reach);
        if (std::ranges::count(shown, path) > 0) most_shown = std::max(most_shown, reach);
        if (reach <= most) continue;
        most = reach;
        farthest = &path;
      }
      if (!farthest || !(most - most_shown > 0.01 * (most - least))) continue;
      if (!std::ranges::count(far, *farthest)) far.push_back(*farthest);
    }
  return far;
}

void add_subject(const Subject& one, Subject& all) {
  const int frame = all.grids.empty() ? 0 : all.grids.back().frame + 1;
  if (all.grids.empty()) {
    all = one;
  } else {
    all.grids.insert(all.grids.end(), one.grids.begin(), one.grids.end());
    all.box_min = glm::min(all.box_min, one.box_min);
    all.box_max = glm::max(all.box_max, one.box_max);
    if (all.z_up.empty()) all.z_up = one.z_up;
  }
  for (std::size_t n = all.grids.size() - one.grids.size(); n < all.grids.size(); ++n)
    all.grids[n].frame = frame;
}

Scene AdaptiveDomain::placed(Scene scene, const GridPlace& place) const {
  if (!(place.voxel_size > 0) || place.domain == glm::ivec3(0)) return scene;
  const double factor = voxel_size / place.voxel_size;
  const glm::dvec3 own = 0.5 * place.voxel_size * glm::dvec3(place.domain.x, place.domain.y, 0);
  scene.translate = glm::dvec3(node_placement(scene) * glm::dvec4(floor - factor * own, 1));
  scene.scale *= factor;
  return scene;
}

}  // namespace psivox
