#include "march/march_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "field/index_space.h"
#include "march/glsl_subset.h"
#include "march/preintegration.h"
#include "march/transfer_table.h"
#include "psivox/error.h"
#include "scene/cuts.h"
#include "scene/transfer_function.h"

namespace psivox {

namespace glsl {
namespace {

/// The exact share in double, and the factor that the shader multiplies by.
struct PsiTable {
  int psi_table_first = 0;
  real4 fetch_table(int) const { return real4(0); }

#define REAL_BITS 64
// each file uses the ones before it
// clang-format off
#include "math/decay.glsl"
#include "math/linear_psi.glsl"
#include "math/segment.glsl"
#include "integrators/psi_table.glsl"
  // clang-format on
#undef REAL_BITS

  /// x of a place. The limits stand for 0 and for ever: the thin share depends on the ends' ratio
  /// alone, and at 1e16 the share is at its limit to 1e-8.
  real x_at(int place) {
    if (place == 0) return 1e16;
    const real root = 2.0 * psi_table_size / place - 2.0;
    return max(root * root, 1e-9);
  }

  float value(int front, int back) {
    const real x_f = x_at(front), x_b = x_at(back);
    const Decay d = decay(0.5 * (x_f + x_b));
    return float(linear_psi(x_f, x_b, d.e).back / d.a / psi_table_factor(x_f, x_b));
  }
};

}  // namespace
}  // namespace glsl

std::vector<glm::vec4> make_psi_table() {
  glsl::PsiTable table;
  const int n = table.psi_table_size;
  std::vector<float> values;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) values.push_back(table.value(i, j));
  std::vector<glm::vec4> entries;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const float* corner = &values[std::size_t(i * (n + 1) + j)];
      entries.emplace_back(corner[0], corner[1], corner[n + 1], corner[n + 2]);
    }
  return entries;
}

namespace {

/// The line's next crossing of a face between voxels along one axis.
struct Crossing {
  int axis;
  double at;  ///< [planes along the main axis]
};

/// Appends numbers, four an entry.
int append(const std::vector<float>& numbers, MarchSetup& setup) {
  std::vector<glm::vec4> entries((numbers.size() + 3) / 4);
  for (std::size_t i = 0; i < numbers.size(); ++i) entries[i / 4][int(i % 4)] = numbers[i];
  return append(entries, setup);
}

}  // namespace

RayTemplate make_ray_template(const glm::dvec3& direction, int planes, int connectivity) {
  constexpr int most = 1 << 22;
  if (planes > most / 3)
    throw Error(ExitCode::usage,
                "--sampling template: the grid is too wide for a template; use --sampling uniform");
  RayTemplate result;
  const glm::dvec3 size = glm::abs(direction);
  result.axis = longest_axis(size);
  const glm::dvec3 slope = direction / size[result.axis];
  const glm::dvec3 sign = glm::sign(direction);

  const auto add = [&](const glm::dvec3& offset) {
    const double t = glm::dot(offset, direction) / glm::dot(direction, direction);
    result.entries.emplace_back(offset, t);
  };
  glm::dvec3 voxel(0);
  add(voxel);
  std::array<int, 3> crossed{};  ///< faces along each axis so far
  for (int plane = 1; plane <= planes; ++plane) {
    // the faces that the line crosses on its way from plane to plane, in order
    std::vector<Crossing> crossings;
    for (int axis = 0; axis < 3; ++axis)
      for (;;) {
        const double at = (crossed[std::size_t(axis)] + 0.5) / std::abs(slope[axis]);
        if (!(at < plane)) break;
        crossings.push_back({axis, at});
        ++crossed[std::size_t(axis)];
      }
    std::sort(crossings.begin(), crossings.end(),
              [](const Crossing& a, const Crossing& b) { return a.at < b.at; });
    const std::size_t together = connectivity == 26 ? 3 : connectivity == 18 ? 2 : 1;
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      voxel[crossings[i].axis] += sign[crossings[i].axis];
      if ((i + 1) % together == 0 || i + 1 == crossings.size()) add(voxel);
    }
  }
  result.spacing = result.entries.back().w / double(result.entries.size() - 1);
  return result;
}

int append(const std::vector<glm::vec4>& entries, MarchSetup& setup) {
  const int first = int(setup.tables.size());
  setup.tables.insert(setup.tables.end(), entries.begin(), entries.end());
  return first;
}

void place_transfer(const TransferFunction& function, MarchSetup& setup) {
  const TransferTable table = make_transfer_table(function);
  MarchParameters& p = setup.parameters;
  p.transfer_first = append(table.entries, setup);
  p.transfer_knots = table.knots;
  p.transfer_bins_first = p.transfer_first + 4 * table.knots;
  p.transfer_bins = table.bins;
  p.transfer_min = table.min;
  p.transfer_bin_scale = table.bin_scale;
  setup.constants.one_interval = table.knots == 2;
  setup.search_steps = table.search_steps;
  setup.constants.transfer_search = table.search_steps > 0;
}

void place_ramps(const Ramps& ramps, MarchSetup& setup) {
  setup.constants.ramps = true;
  setup.parameters.ramp_base = ramps.base;
  setup.parameters.ramp_knots = ramps.knots;
  setup.parameters.ramp_slopes = ramps.slopes;
}

void place_gradient(const TransferFunction& function, MarchSetup& setup) {
  MarchParameters& p = setup.parameters;
  setup.constants.with_gradient = true;
  const GradientEntries part = make_gradient_entries(function);
  p.gradient_first = append(part.entries, setup);
  p.gradient_columns = part.columns;
  p.isosurfaces = part.isosurfaces;
  p.isosurfaces_first = p.gradient_first + int(part.entries.size()) - part.isosurfaces;
  setup.search_steps += part.search_steps + part.isosurfaces;
}

void place_surfaces(const View& view, MarchSetup& setup) {
  std::vector<glm::vec4> entries;
  MarchParameters& p = setup.parameters;
  for (const Surface& surface : view.medium.surfaces) {
    entries.emplace_back(float(surface.isovalue), 0, 0, 0);
    entries.emplace_back(glm::vec3(surface.color), surface.opacity);
    setup.constants.veils |= surface.opacity < 1;
  }
  p.surfaces_first = append(entries, setup);
  p.surfaces = int(entries.size() / 2);
  p.first_isovalue = double(entries.front().x);
  p.last_isovalue = double(entries[entries.size() - 2].x);
  entries.clear();
  for (const ParallelLight& light : surface_lights(view)) {
    entries.emplace_back(glm::vec3(light.direction), 0);
    entries.emplace_back(glm::vec3(light.radiance), 0);
  }
  p.surface_lights_first = append(entries, setup);
  p.surface_lights = int(entries.size() / 2);
}

void place_passed(const std::vector<float>& passed, const PixelBox& pixels, MarchSetup& setup) {
  if (passed.empty()) return;
  MarchParameters& p = setup.parameters;
  p.passed_first = append(passed, setup);
  p.passed_x = pixels.origin.x;
  p.passed_y = pixels.origin.y;
  p.passed_width = pixels.size.x;
  setup.constants.has_passed = true;
}

void place_clip(const View& view, double anchor_distance, MarchSetup& setup) {
  const std::vector<HalfSpace> cuts = cuts_of(view.scene);
  if (cuts.empty()) return;
  const Camera& camera = view.camera;
  MarchParameters& p = setup.parameters;
  std::vector<glm::vec4> entries;
  const auto add = [&](const glm::dvec3& coefficients) {
    const glm::vec3 high(coefficients);
    entries.emplace_back(high, 0);
    entries.emplace_back(glm::vec3(coefficients - glm::dvec3(high)), 0);
  };
  const glm::dvec3 anchor = camera.position + anchor_distance * camera.forward;
  const double spread = camera.orthographic ? 1 : anchor_distance;
  for (const HalfSpace& half : cuts) {
    const double unit = p.world_unit;
    const glm::dvec3 across(0, glm::dot(half.normal, camera.right) * camera.half_width,
                            glm::dot(half.normal, camera.up) * camera.half_height);
    const glm::dvec3 at(glm::dot(half.normal, anchor) - half.offset, 0, 0);
    const glm::dvec3 along(glm::dot(half.normal, camera.forward), 0, 0);
    add((at + spread * across) / unit);
    add(camera.orthographic ? along : along + across);
  }
  p.clip_first = append(entries, setup);
  p.clip_planes = int(clip_of(view.scene).size());
  setup.constants.clips = p.clip_planes > 0;
}

void place_holdout(const View& view, double anchor_distance, MarchSetup& setup) {
  if (!view.holdout) return;
  const glm::ivec2 size = view.scene.resolution;
  constexpr double far = 1e30;  // beyond every ray, in float32 too
  std::vector<float> depths;
  depths.reserve(std::size_t(size.x) * std::size_t(size.y));
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) {
      const double z = view.holdout->z(view.camera, size, {x, y}) - anchor_distance;
      depths.push_back(float(std::min(z / setup.parameters.world_unit, far)));
    }
  setup.parameters.held_first = append(depths, setup);
  setup.parameters.held_width = size.x;
  setup.constants.holds_out = true;
}

void place_template(const View& view, MarchSetup& setup) {
  MarchParameters& p = setup.parameters;
  const glm::ivec3 size = p.density.domain_max - p.density.domain_min;
  // a few more than there are
  const int planes = std::max({size.x, size.y, size.z}) + 8;
  const RayTemplate made = make_ray_template(p.density.direction_0 / glm::length(p.world_0), planes,
                                             view.scene.connectivity);
  p.template_first = append(made.entries, setup);
  p.template_entries = int(made.entries.size());
  p.template_axis = made.axis;
  p.template_spacing = made.spacing;
}

void place_brick_steps(const std::vector<float>& parts, const BrickAtlas& density,
                       MarchSetup& setup) {
  if (parts.size() != density.bricks.size())
    throw Error(ExitCode::failure, "the bricks' steps are not of the view's atlas");
  setup.constants.brick_steps = true;
  std::vector<float> by_payload;
  for (std::size_t slot = 0; slot < parts.size(); ++slot) {
    if (setup.constants.coded) by_payload.resize(density.code_places[slot]);
    by_payload.push_back(parts[slot]);
  }
  setup.parameters.brick_steps_first = append(by_payload, setup);
}

std::shared_ptr<const PreintegratedTable> preintegration_of(const View& view, bool may_update) {
  const Field& density = *view.medium.density;
  const double unit = finest_voxel(density);
  const bool uniform = view.scene.resolved_sampling() == Sampling::uniform;
  const double longest = diagonal_of(density, glm::dvec3(1)) / unit;
  const double length = uniform ? view.scene.resolved_step() : longest / view.scene.segments;
  return preintegrated_table(*view.medium.transfer, view.medium.extinction * unit, length, uniform,
                             may_update);
}

void place_preintegration(const View& view, bool may_update, MarchSetup& setup) {
  MarchParameters& p = setup.parameters;
  setup.preintegration = preintegration_of(view, may_update);
  const PreintegratedTable& table = *setup.preintegration;
  p.preintegration_first = append(table.entries(), setup);
  p.preintegration_size = table.size();
  p.preintegration_layers = table.layers();
  p.preintegration_scale = table.scale();
  p.preintegration_length = table.max_length();
}

void place_psi_table(MarchSetup& setup) {
  static const std::vector<glm::vec4> table = make_psi_table();
  setup.parameters.psi_table_first = append(table, setup);
}

}  // namespace psivox
