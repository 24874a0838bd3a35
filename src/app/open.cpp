#include "psivox/open.h"

#include <algorithm>
#include <utility>

namespace psivox {

OpenedScene open_scene(const Scene& scene, const VdbFile& file, const OpenOptions& options) {
  OpenedScene opened{with_look(scene, file, options.open_look, options.background, options.parts),
                     {}};
  opened.view = make_view(opened.looked.scene, opened.looked.fields);
  return opened;
}

OpenedScene open_scene(const Scene& scene, MediumFields fields) {
  View view = make_view(scene, fields);
  return {{.scene = scene, .look = "plain", .settings = {}, .fields = std::move(fields)},
          std::move(view)};
}

std::vector<std::string> notices_of(const Medium& medium) {
  std::vector<std::string> all;
  // fields made from one grid repeat its notices
  for (const auto& field : {medium.density, medium.luminance, medium.emission})
    if (field)
      for (const std::string& notice : field->notices)
        if (!std::ranges::count(all, notice)) all.push_back(notice);
  return all;
}

}  // namespace psivox
