#include <algorithm>
#include <utility>

#include "base/text.h"
#include "field/index_space.h"
#include "field/value_range.h"
#include "psivox/open.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

/// What to say if values below 0 lie in a shell: beside the voxels the value is 0, which a function
/// shows, or which is beyond a surface. Empty: they do not.
std::string shell_notice(const View& view) {
  const Scene& scene = view.scene;
  const Medium& medium = view.medium;
  const Field& field = *medium.density;
  if (scene.clip || scene.clip_plane || field.half_width > 0 || field.margin == 0 ||
      scene.shows(Shows::plane))
    return "";
  const bool surface = scene.shows(Shows::surface);
  if (surface ? scene.isovalue.empty() || scene.isovalue.front().value >= 0
              : !medium.transfer || medium.transfer->has_gradient() || scene.shows(Shows::value) ||
                    medium.transfer->max_attenuation(0, 0) == 0)
    return "";
  const double least = stored_range(field).x;
  if (surface ? least >= medium.surfaces.front().isovalue : least >= 0) return "";
  const auto [first, last] = bounds_of(field.active_box, field.world_from_index);
  return "grid " + in_quotes(field.name) +
         ": values below 0 lie in a shell: beside the voxels the value is 0, which " +
         (surface ? "is beyond the surface" : "the function shows") + "; --clip " +
         formatted("%.7g,%.7g,%.7g,%.7g,%.7g,%.7g", first.x, first.y, first.z, last.x, last.y,
                   last.z) +
         " leaves the shell out";
}

std::vector<std::string> notices_of_fields(const Medium& medium) {
  std::vector<std::string> all;
  for (const Medium& other : medium.others)
    for (std::string& notice : notices_of_fields(other)) all.push_back(std::move(notice));
  // fields made from one grid repeat its notices
  const auto add = [&](const Field& field) {
    for (const std::string& notice : field.notices)
      if (!std::ranges::count(all, notice)) all.push_back(notice);
  };
  add(*medium.density);
  if (medium.luminance) add(*medium.luminance);
  for (const Emission& emission : medium.emission) add(*emission.field);
  return all;
}

}  // namespace

std::vector<std::string> notices_of(const View& view) {
  std::vector<std::string> all = notices_of_fields(view.medium);
  if (std::string shell = shell_notice(view); !shell.empty()) all.push_back(std::move(shell));
  return all;
}

}  // namespace psivox
