#include "notices.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "psivox/parameters.h"

namespace psivox {

void print_notices(const View& view, bool chose_extinction) {
  // Fields made from one grid repeat its notices.
  std::vector<std::string> printed;
  const Medium& medium = view.medium;
  for (const auto& field : {medium.density, medium.luminance, medium.emission}) {
    if (!field) continue;
    for (const std::string& notice : field->notices) {
      if (std::find(printed.begin(), printed.end(), notice) != printed.end()) continue;
      printed.push_back(notice);
    }
  }
  print_notices(printed);
  if (chose_extinction)
    std::fprintf(stderr, "psivox: extinction %s [1/world unit], chosen by auto\n",
                 parameter_text(view.scene, *find_parameter("extinction")).c_str());
}

void print_notices(std::span<const std::string> notices) {
  for (const std::string& notice : notices) std::fprintf(stderr, "psivox: %s\n", notice.c_str());
}

}  // namespace psivox
