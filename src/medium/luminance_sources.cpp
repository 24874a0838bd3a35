#include "medium/luminance_sources.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/text.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "medium/map_field.h"
#include "psivox/error.h"
#include "scene/color.h"
#include "vdb/grid_names.h"

namespace psivox {
namespace {

std::shared_ptr<const Field> share(Field field) {
  return std::make_shared<const Field>(std::move(field));
}

/// Temperature at which a black body begins to glow visibly (J. W. Draper, 1847) [K].
constexpr double draper_point = 798;

/// The greatest code if the numbers are codes of 8 to 16 bits, else 0. Codes are whole, some of
/// them above 1; or any up to 255, some of them far above what a colour has: codes that were
/// resampled are no whole numbers.
double greatest_code(const Field& colors) {
  constexpr double far_above = 30, least_bits = 255, most_bits = 65535;
  if (colors.value_type.find("uint8") != colors.value_type.npos) return least_bits;
  const double greatest = greatest_value(colors);
  if (!(greatest > 1) || greatest > most_bits) return 0;
  if (greatest > far_above && greatest <= least_bits) return least_bits;
  const auto is_whole = [](float v) { return v >= 0 && v == std::floor(v); };
  const bool whole =
      fold_leaves(
          colors, true,
          [&](bool& all, const Leaf&, const OrderedValues& values) {
            all = all && std::ranges::all_of(values, is_whole);
          },
          std::logical_and<>()) &&
      std::ranges::all_of(colors.tiles, [&](const Tile& tile) {
        return is_whole(tile.value.x) && is_whole(tile.value.y) && is_whole(tile.value.z);
      });
  double most = least_bits;  // cameras have 8, 10, 12, 14 or 16 bits
  while (most < greatest) most = 4 * most + 3;
  return whole ? most : 0;
}

/// Replaces negative luminance by 0. Reading does so too, except if the luminance is also the
/// density and has the role of data.
std::shared_ptr<const Field> without_negative(std::shared_ptr<const Field> field) {
  if (!(range_of_all(*field).x < 0)) return field;
  return share(map_field(*field, field->channels,
                         [](const glm::vec3& value) { return glm::max(value, glm::vec3(0)); }));
}

void set_grid(const std::shared_ptr<const Field>& field, Medium& medium) {
  if (field == medium.density) {
    medium.source = LuminanceSource::density;
    return;
  }
  medium.source = field->channels == 3 ? LuminanceSource::vector : LuminanceSource::scalar;
  medium.luminance = field;
}

void set_function(const std::shared_ptr<const TransferFunction>& function,
                  const MediumFields& fields, Medium& medium) {
  if (medium.transfer) {
    medium.source = LuminanceSource::transfer;
    return;
  }
  medium.source = LuminanceSource::vector;
  medium.luminance = share(color_of_voxels(*fields.density, *function));
}

}  // namespace

bool names_colors(const std::string& grid) {
  const std::vector<std::string> words = name_words(grid);
  const auto has = [&](const char* word) { return std::ranges::count(words, word) > 0; };
  return has("rgb") || std::ranges::any_of(color_words, has);
}

Field linear_colors(Field colors) {
  if (colors.channels != 3 || !names_colors(colors.name)) return colors;
  const double most = greatest_code(colors);
  if (most == 0) return colors;
  Field linear = map_field(colors, 3, [&](const glm::vec3& code) {
    return glm::vec3(linear_from_srgb(glm::dvec3(code) / most));
  });
  if (colors.value_type.find("uint8") == colors.value_type.npos)
    linear.notices.push_back(
        formatted("grid '%s': its colours, numbers up to %g, are taken as sRGB codes",
                  colors.name.c_str(), most));
  return linear;
}

Field black_bodies(const Scene& scene, const Field& temperature) {
  if (temperature.channels != 1)
    throw Error(ExitCode::input, "grid " + in_quotes(temperature.name) + " has vectors (" +
                                     temperature.value_type +
                                     "); a temperature is scalar: choose another grid");
  const auto kelvin = [&](double value) {
    return scene.temperature_scale * value + scene.temperature_offset;
  };
  Field luminance = map_field(temperature, 3, [&](const glm::vec3& value) {
    if (value.x == 0) return glm::vec3(0);
    return glm::vec3(black_body(kelvin(double(value.x))));
  });
  const double hottest = kelvin(stored_range(temperature).y);
  if (hottest < draper_point)
    luminance.notices.push_back(
        formatted("grid '%s': its hottest voxel has %.4g K, and black bodies glow from about 800 K "
                  "on%s",
                  temperature.name.c_str(), hottest,
                  scene.given.contains("temperature-scale")
                      ? ""
                      : "; --temperature-scale gives Kelvin per unit of its values"));
  return luminance;
}

glm::dvec3 greatest_glow(const Medium& medium) {
  if (medium.source == LuminanceSource::constant) return glm::dvec3(1);
  if (medium.luminance) return glm::dvec3(greatest_value(*medium.luminance));
  const glm::dvec2 range = stored_range(*medium.density);
  if (medium.source == LuminanceSource::density) return glm::dvec3(range.y);
  return medium.transfer->max_color(range.x, range.y);
}

void set_luminance(const Scene& scene, const MediumFields& fields,
                   const std::shared_ptr<const TransferFunction>& function, Medium& medium) {
  medium.color = scene.resolved_luminance();
  if (scene.shows(Shows::depth) || (scene.composites() && !scene.shines())) return;
  const bool tinted = function && function->has_color();
  if (tinted) {
    if (scene.composites() || medium.transfer) set_function(function, fields, medium);
  } else if (fields.temperature) {
    medium.source = LuminanceSource::vector;
    medium.luminance = share(black_bodies(scene, *fields.temperature));
  } else if (fields.luminance) {
    set_grid(without_negative(fields.luminance), medium);
    medium.color *= scene.luminance_scale;
  }
  if (!scene.lit()) return;
  medium.light =
      ScatteredLight{{}, scene.sky.value_or(glm::dvec3(0)) * scene.albedo, tinted, fields.albedo};
  for (const DirectionalLight& light : scene.lights)
    medium.light->lights.push_back(
        {glm::normalize(light.direction), light.color * scene.albedo, light.of_camera});
}

}  // namespace psivox
