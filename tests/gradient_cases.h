#pragma once

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <memory>
#include <random>
#include <string>

#include "made_fields.h"
#include "psivox/medium.h"
#include "scene/transfer_function.h"
#include "scratch.h"

// Shared by the tests of functions of value and gradient.

namespace psivox {

/// A view of a field through a function, which is read from a file as in the program.
inline View view_by(Scene scene, const TransferFunction& function, Field density) {
  scene.transfer_function = test::write_bytes("function.json", to_json(function)).string();
  return make_view(scene, std::make_shared<const Field>(std::move(density)), nullptr);
}

/// 1 in the middle, 0 at radius 9.
inline Field ball() {
  return make_field({{0, 0, 0}, {20, 20, 20}}, [](glm::ivec3 v) {
    const glm::dvec3 d = (glm::dvec3(v) - 10.0) / 9.0;
    return float(std::max(0.0, 1 - glm::dot(d, d)));
  });
}

/// Over values from 0.05 to 1.2 and gradients from 0.02 to 0.2.
inline const TransferFunction table(
    {{0.05, 0, {1, 0.2, 0}}, {0.3, 0, {0.2, 1, 0}}, {0.5, 0, {0, 0.5, 1}}, {1.2, 0, {1, 1, 1}}},
    true,
    {.gradients = {0.02, 0.08, 0.2},
     .attenuation = {0, 0, 0, 0, 0.5, 0.1, 0.1, 0.2, 0.6, 0.02, 0.3, 0}});

/// Two isosurfaces in two colours.
inline const TransferFunction shells({{0, 0, {1, 0.2, 0}},
                                      {0.4, 0, {1, 0.2, 0}},
                                      {0.6, 0, {0, 0.5, 1}}},
                                     true, {.isosurfaces = {{0.3, 1.5, 0.5}, {0.7, 1, 1}}});

/// Points over [0, 1] with colours; kind 0: a table and isosurfaces, 1: a table, 2: isosurfaces, 3:
/// one column, a jump and isosurfaces. Some attenuations are 0.
inline TransferFunction random_gradient_function(std::mt19937_64& random, int kind = 0) {
  std::uniform_real_distribution<double> u(0, 1);
  const auto attenuation = [&] { return std::max(0.0, 2 * u(random) - 1); };
  std::vector<TransferPoint> points;
  for (int k = 0; k < 5; ++k)
    points.push_back({(k + u(random)) / 5, attenuation(), {u(random), u(random), u(random)}});
  if (kind == 3) points[2].value = points[3].value;
  GradientPart part;
  double gradient = 0;
  for (int j = 0; kind != 2 && j < (kind == 3 ? 1 : 4); ++j)
    part.gradients.push_back(gradient += 0.01 + 0.3 * u(random));
  for (std::size_t i = 0; i < points.size() * part.gradients.size(); ++i)
    part.attenuation.push_back(attenuation());
  for (int i = 0; kind != 1 && i < 2; ++i)
    part.isosurfaces.push_back({u(random), 0.1 + u(random), u(random)});
  return TransferFunction(points, true, part);
}

}  // namespace psivox
