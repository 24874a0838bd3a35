#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "psivox/scene.h"

namespace psivox {

/// Stands before the direction of a light that turns with the camera.
inline constexpr std::string_view camera_prefix = "camera:";

/// Stands for the environment's map behind the medium.
inline constexpr std::string_view environment_word = "environment";

/// Names on the command line of an enumeration's values, in their order from 0.
inline std::vector<std::string> enum_names(Sampling) { return {"cells", "uniform", "template"}; }
inline std::vector<std::string> enum_names(Classification) { return {"post", "pre", "nearest"}; }
inline std::vector<std::string> enum_names(Centering) { return {"node", "cell"}; }
inline std::vector<std::string> enum_names(Colormap) {
  return {"viridis", "inferno",  "magma", "plasma", "cividis",
          "turbo",   "coolwarm", "gray",  "hot",    "labels"};
}
inline std::vector<std::string> enum_names(ValueScale::Kind) { return {"linear", "log", "symlog"}; }
inline std::vector<std::string> enum_names(Filter) { return {"exact", "hardware"}; }
inline std::vector<std::string> enum_names(Projection) { return {"perspective", "orthographic"}; }
inline std::vector<std::string> enum_names(UpAxis) { return {"auto", "y", "z"}; }
inline std::vector<std::string> enum_names(RendererKind) {
  return {"gl", "reference", "march-double"};
}
inline std::vector<std::string> enum_names(TexelType) {
  return {"auto", "float32", "code7", "code12", "code16"};
}
inline std::vector<std::string> enum_names(DepthKind) { return {"z", "distance"}; }
inline std::vector<std::string> enum_names(ToneMap) { return {"none", "filmic"}; }
/// The names of a table's rows, with dashes.
template <typename Table>
std::vector<std::string> row_names(const Table& table) {
  std::vector<std::string> names;
  for (const auto& row : table) {
    names.emplace_back(row.name);
    std::replace(names.back().begin(), names.back().end(), '_', '-');
  }
  return names;
}
inline std::vector<std::string> enum_names(Mode) { return row_names(mode_rows); }
inline std::vector<std::string> enum_names(Integrator) { return row_names(integrators); }
inline std::vector<std::string> enum_names(EmissionColor) { return {"white", "black-body"}; }
inline std::vector<std::string> enum_names(LightQuality) { return {"auto", "exact"}; }

template <typename E>
std::string enum_metavar() {
  return joined(enum_names(E{}), "|");
}

}  // namespace psivox
