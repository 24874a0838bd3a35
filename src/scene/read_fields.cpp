#include <memory>

#include "psivox/medium.h"

namespace psivox {
namespace {

std::shared_ptr<const Field> read(const VdbFile& file, const std::string& grid,
                                  const ReadOptions& options) {
  return std::make_shared<const Field>(file.read(grid, options));
}

}  // namespace

MediumFields read_fields(const Scene& scene, const VdbFile& file) {
  MediumFields fields;
  fields.z_up = file.z_up();
  const bool surface = scene.mode == Mode::isosurface;
  const bool data = scene.has_function() || surface;
  const std::string grid = scene.grid.empty() ? file.default_grid() : scene.grid;
  fields.density =
      read(file, grid, {data ? GridRole::data : GridRole::attenuation, scene.strict, surface});
  if (!scene.composites()) return fields;

  // A grid that is also the density is read once, unless a function maps the density, whose values
  // may then be negative. One grid may have two names: `density` is also `density[0]`.
  const auto luminance = [&](const std::string& name) {
    if (name == grid && !data) return fields.density;
    auto field = read(file, name, {GridRole::luminance, scene.strict});
    return field->name == fields.density->name && !data ? fields.density : field;
  };
  if (scene.shines() && !scene.luminance_grid.empty())
    fields.luminance = luminance(scene.luminance_grid);
  if (scene.emission_scale > 0 && !scene.emission_grid.empty())
    fields.emission = luminance(scene.emission_grid);
  if (scene.shines() && !scene.temperature_grid.empty())
    fields.temperature = read(file, scene.temperature_grid, {GridRole::data, scene.strict});
  return fields;
}

}  // namespace psivox
