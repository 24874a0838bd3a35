// Transfer functions of value and gradient: their numbers, their file, the gradient of voxels,
// refused input, and the reference.

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <random>
#include <string>

#include "field_voxels.h"
#include "gradient_cases.h"
#include "medium/map_field.h"
#include "psivox/error.h"
#include "reference_cases.h"
#include "scene/transfer_function.h"
#include "thrown.h"

namespace psivox {
namespace {

// --- functions -----------------------------------------------------------------------------------

TEST(GradientPart, IsBilinearBetweenKnotsAndConstantBeyond) {
  const TransferFunction f({{1, 7, {}}, {3, 0, {}}}, false,
                           {.gradients = {2, 4}, .attenuation = {1, 2, 3, 5}});
  EXPECT_EQ(f.attenuation(1, 2), 1);
  EXPECT_EQ(f.attenuation(1, 4), 2);
  EXPECT_EQ(f.attenuation(3, 2), 3);
  EXPECT_EQ(f.attenuation(2, 3), (1 + 2 + 3 + 5) / 4.0);
  EXPECT_EQ(f.attenuation(1.5, 2.5), 0.75 * (0.75 * 1 + 0.25 * 2) + 0.25 * (0.75 * 3 + 0.25 * 5));
  EXPECT_EQ(f.attenuation(0, 0), 1);
  EXPECT_EQ(f.attenuation(9, 9), 5);
  EXPECT_EQ(f.at(1).attenuation, 2);  // the largest in the row
  EXPECT_EQ(f.at(3).attenuation, 5);
  EXPECT_TRUE(f.has_gradient());
  EXPECT_FALSE(TransferFunction({{1, 7, {}}}).has_gradient());
}

TEST(GradientPart, AddsShellsThatAreAsWideAsTheGradientIsSteep) {
  const TransferFunction f({TransferPoint{}}, false, {.isosurfaces = {{2, 0.5, 8}, {3, 1, 1}}});
  EXPECT_EQ(f.attenuation(2, 1), 8);
  EXPECT_EQ(f.attenuation(2.25, 1), 4 + 0.25);
  EXPECT_EQ(f.attenuation(1.75, 1), 4);
  EXPECT_EQ(f.attenuation(1.5, 1), 0);
  EXPECT_EQ(f.attenuation(1.5, 2), 4 + 0.25);
  EXPECT_EQ(f.attenuation(2, 0), 8);
  EXPECT_EQ(f.attenuation(std::nextafter(2.0, 3), 0), 0);
}

TEST(GradientPart, ReturnsFromItsFileBitForBit) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) {
    const TransferFunction f = random_gradient_function(random, i % 4);
    EXPECT_EQ(transfer_function_from_json(to_json(f), "a.json"), f) << to_json(f);
  }
  const TransferFunction f = transfer_function_from_json(
      R"({"gradients": [0, 0.5], "points": [{"value": 0, "attenuation": 1},
          {"value": 1, "attenuation": [2, 3]}]})",
      "a.json");
  EXPECT_EQ(f.gradient_part().attenuation, (std::vector<double>{1, 1, 2, 3}));
  const TransferFunction alone = transfer_function_from_json(
      R"({"isosurfaces": [{"value": 0.5, "thickness": 2, "attenuation": 3}]})", "a.json");
  EXPECT_FALSE(alone.has_color());
  EXPECT_EQ(alone.attenuation(0.5, 0.1), 3);
  EXPECT_EQ(alone.attenuation(0, 0), 0);
}

TEST(GradientPart, RefusesInOneLine) {
  const auto error = [](const std::string& text) {
    return error_of(ExitCode::input, [&] { transfer_function_from_json(text, "a.json"); });
  };
  const auto table = [&](const std::string& gradients, const std::string& row) {
    return error("{\"gradients\": " + gradients +
                 ", \"points\": [{\"value\": 0, \"attenuation\": " + row + "}]}");
  };
  EXPECT_EQ(table("[0, 1]", "[1, 2]"), "no error");
  EXPECT_EQ(table("[]", "[]"), "a.json: gradients: expected at least one");
  EXPECT_EQ(table("3", "[1]"), "a.json: gradients: expected an array");
  EXPECT_EQ(table("[1, 1]", "[1, 2]"), "a.json: gradients must ascend, but 1 follows 1");
  EXPECT_EQ(table("[-1, 1]", "[1, 2]"), "a.json: gradient -1 is negative");
  EXPECT_EQ(table("[0, 1]", "[1, 2, 3]"),
            "a.json: point 1 of the transfer function: attenuation: has 3 numbers for 2 gradients");
  EXPECT_EQ(table("[0, 1]", "[1, -2]"), "a.json: attenuation -2 is negative");
  EXPECT_EQ(error(R"({"points": [{"value": 0, "attenuation": [1]}]})"),
            "a.json: point 1 of the transfer function: attenuation: has 1 numbers for 0 gradients");
  EXPECT_EQ(error(R"({"gradient": [0], "points": []})"),
            "a.json: the transfer function: unknown key 'gradient'; did you mean gradients?");
  const auto surface = [&](const std::string& text) {
    return error("{\"isosurfaces\": [" + text + "]}");
  };
  EXPECT_EQ(surface(R"({"value": 1, "thickness": 1, "attenuation": 1})"), "no error");
  EXPECT_EQ(surface(R"({"value": 1, "thickness": 0, "attenuation": 1})"),
            "a.json: thickness of an isosurface is 0; nothing of it would be seen");
  EXPECT_EQ(surface(R"({"value": 1, "thickness": -1, "attenuation": 1})"),
            "a.json: thickness of an isosurface -1 is negative");
  EXPECT_EQ(surface(R"({"value": 1, "attenuation": 1})"),
            "a.json: isosurface 1 of the transfer function: has no thickness");
  EXPECT_EQ(surface(R"({"value": 1, "thicknes": 1, "attenuation": 1})"),
            "a.json: isosurface 1 of the transfer function: unknown key 'thicknes'; did you mean "
            "thickness?");
  EXPECT_EQ(surface("4"),
            "a.json: isosurface 1 of the transfer function: expected an object of "
            "value, thickness and attenuation");
  EXPECT_NE(surface(R"({"value": 1e99, "thickness": 1, "attenuation": 1})"), "no error");
}

TEST(GradientPart, RefusesWhatNeedsAFunctionOfOneVariable) {
  const auto error = [](auto set) {
    Scene scene;
    set(scene);
    return error_of(ExitCode::usage, [&] { view_by(scene, table, ball()); });
  };
  EXPECT_EQ(error([](Scene&) {}), "no error");
  const std::string mip = error([](Scene& s) { s.mode = Mode::mip; });
  EXPECT_TRUE(has(mip, "has gradients: a greatest value has none; take --mode alpha"));
  EXPECT_NE(error([](Scene& s) { s.mode = Mode::lmip; }), "no error");
  EXPECT_TRUE(has(error([](Scene& s) { s.split_knots = true; }), "leave it out"));
  for (const Integrator rule :
       {Integrator::cell_exact, Integrator::preintegrated, Integrator::preintegrated_fast})
    EXPECT_TRUE(has(error([=](Scene& s) { s.integrator = rule; }), "take psi-weighted"));
  EXPECT_EQ(error([](Scene& s) { s.mode = Mode::isosurface; }), "no error");
  EXPECT_EQ(error([](Scene& s) { s.mode = Mode::xray; }), "no error");
  EXPECT_EQ(error([](Scene& s) {
              s.classification = Classification::pre;
              s.integrator = Integrator::cell_exact;
            }),
            "no error");
}

// --- voxels --------------------------------------------------------------------------------------

TEST(GradientOfVoxels, IsExactOfLinearFieldsInAnyTransform) {
  const glm::dvec3 slope(0.7, -0.4, 1.1);  // [value/world unit]
  for (const glm::dmat4& m : {glm::dmat4(1), sheared}) {
    const Field field = make_field(
        {{-3, 2, 5}, {12, 14, 20}},
        [&](glm::ivec3 v) { return float(glm::dot(slope, glm::dvec3(m * glm::dvec4(v, 1)))); }, m);
    const Field of_voxels = gradient_of_voxels(field);
    const FieldVoxels gradient(of_voxels);
    const glm::dmat3 normal = glm::transpose(glm::inverse(glm::dmat3(m)));
    double size = 0;
    for (int axis = 0; axis < 3; ++axis) size += glm::dot(normal[axis], normal[axis]);
    // Values below 64 are exact to 2^-19, and so is half a difference; then one float32 rounding.
    const double off = std::sqrt(size) * std::sqrt(3.0) * 0x1p-19 + 0x1p-23;
    for_points({{-2, 3, 6}, {11, 13, 19}}, [&](const glm::ivec3& v) {
      ASSERT_NEAR(double(gradient(v).x), glm::length(slope), off);
    });
  }
}

/// A wide tile beside leaves, a narrow one, and the same values all in leaves.
Field tiled(bool leaves_only) {
  const auto value = [](glm::ivec3 v) {
    if (v.x >= 128 || v.y >= 128 || v.z >= 128) return noise(v);
    return v.x < 0 ? 0.5f : 0.7f;
  };
  const Box box{{-8, 96, 96}, {135, 135, 135}};
  Field field = make_field(box, value);
  if (leaves_only) return field;
  std::erase_if(field.leaves, [](const Leaf& leaf) {
    return leaf.origin.x < 128 && leaf.origin.y < 128 && leaf.origin.z < 128;
  });
  field.tiles.push_back({{0, 0, 0}, 128, glm::vec3(0.7f)});
  for (int y = 96; y < 128; y += 8)
    for (int z = 96; z < 128; z += 8) field.tiles.push_back({{-8, y, z}, 8, glm::vec3(0.5f)});
  return field;
}

TEST(GradientOfVoxels, IsThatOfDifferencesWithTilesToo) {
  const Field field = tiled(false);
  const Field field_gradient = gradient_of_voxels(field);
  const FieldVoxels values(field), gradient(field_gradient);
  const Box box = field.domain();
  int some = 0;
  for (int x = box.min.x; x <= box.max.x; ++x)
    for (int y = box.min.y; y <= box.max.y; ++y)
      for (int z = box.min.z; z <= box.max.z; z += 3) {
        const glm::ivec3 v(x, y, z);
        glm::dvec3 d;
        for (int axis = 0; axis < 3; ++axis) {
          glm::ivec3 unit(0);
          unit[axis] = 1;
          d[axis] = (double(values(v + unit).x) - double(values(v - unit).x)) / 2;
        }
        ASSERT_EQ(gradient(v).x, float(glm::length(d))) << x << " " << y << " " << z;
        some += gradient(v).x > 0;
      }
  EXPECT_GT(some, 1000);
  for (const Leaf& leaf : field_gradient.leaves)
    EXPECT_TRUE(std::any_of(leaf.values, leaf.values + 512, [](float g) { return g > 0; }));
}

TEST(AttenuationOfVoxels, IsTheFunctionOfEachVoxel) {
  const Field field = tiled(false);
  const Field gradient = gradient_of_voxels(field);
  const TransferFunction sees_zero({{0, 0, {}}, {0.5, 0, {}}, {1, 0, {}}}, false,
                                   {.gradients = {0, 0.3},
                                    .attenuation = {0, 1, 0.2, 0, 0, 2},
                                    .isosurfaces = {{0.69f, 1, 0.5}}});
  const TransferFunction fills({{0, 0.25, {}}, {1, 1, {}}}, false, {.isosurfaces = {{0.6, 1, 1}}});
  for (const TransferFunction& f : {sees_zero, fills}) {
    const Field result = attenuation_of_voxels(field, gradient, f);
    const FieldVoxels v(field), g(gradient), t(result);
    const Box box = field.domain();
    for (int x = box.min.x; x <= box.max.x; ++x)
      for (int y = box.min.y; y <= box.max.y; y += 3)
        for (int z = box.min.z; z <= box.max.z; ++z) {
          const glm::ivec3 at(x, y, z);
          ASSERT_EQ(t(at).x, float(f.attenuation(double(v(at).x), double(g(at).x))));
        }
  }
}

// --- the reference -------------------------------------------------------------------------------

/// Integrates a ray with very many samples of the interpolated grids, equally many in each cell.
RayRadiance sampled(const Medium& medium, const WorldRay& ray, double length, int samples) {
  const PlainField value(*medium.density), gradient(*medium.gradient);
  std::vector<double> faces{0, length};
  value.add_faces(ray, 0, length, faces);
  std::sort(faces.begin(), faces.end());
  RayRadiance sum;
  for (std::size_t n = 0; n + 1 < faces.size(); ++n) {
    const double h = (faces[n + 1] - faces[n]) / samples;
    for (int i = 0; i < samples; ++i) {
      const glm::dvec3 at = ray.origin + ray.direction * (faces[n] + (i + 0.5) * h);
      if (!value.in_domain(at)) break;
      const double v = value.value(at).x;
      const double x =
          medium.extinction * h * medium.transfer->attenuation(v, gradient.value(at).x);
      sum.radiance += std::exp(-sum.optical_depth) * -std::expm1(-x) * medium.color *
                      medium.transfer->at(v).color;
      sum.optical_depth += x;
    }
  }
  return sum;
}

TEST(GradientReference, AgreesWithSamples) {
  const Field field = sheared_noise();
  std::mt19937_64 random(9);
  for (int i = 0; i < 4; ++i) {
    Medium medium = make_medium(field, 1.5, LuminanceSource::transfer);
    medium.color = {1, 0.5, 2};
    medium.gradient = std::make_shared<const Field>(gradient_of_voxels(field));
    medium.transfer = std::make_shared<const TransferFunction>(random_gradient_function(random, i));
    for (const WorldRay& ray : sheared_rays(3)) {
      const RayRadiance r = ray_radiance(medium, ray);
      // Cells are at most 1 long here, and h = 1/2000 of a cell. The midpoint rule is off by h^2/24
      // times the change of slope: 1e-8 times slopes of 100 (a shell 0.05 wide in value, crossed at
      // 5 per cell), in about 40 cells. At the jump of attenuations up to 1 it is off by h/2 of the
      // jump, about 10 times.
      const RayRadiance s = sampled(medium, ray, 40, 2000);
      const double off = i == 3 ? 1.5 * 10 * 0.5 / 2000 : 4e-5;
      EXPECT_GT(s.optical_depth, 0.05);
      EXPECT_NEAR(r.optical_depth, s.optical_depth, off);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(r.radiance[c], s.radiance[c], off);
      const RayMedium ready(medium);
      const RayRadiance whole = RayIntegrator(ready, 1e-12).whole_depth(ray);
      EXPECT_NEAR(whole.optical_depth, r.optical_depth, whole.error + r.error);
      // fits to 1e-11 of the attenuation, along optical depths of about 10
      EXPECT_LT(r.error, 1e-8);
      EXPECT_LT(whole.error, 1e-8);
    }
  }
}

// Levoy's purpose: shells of constant thickness for any slope. v = f + s (r - R) around a point;
// the slope s varies between 0.5 and 1.5 with direction.
TEST(IsosurfaceShell, IsEquallyThickWhateverTheSlope) {
  const double R = 20, thickness = 2, K = 0.7;
  const glm::dvec3 center(31.7, 32.2, 31.4);
  const auto slope = [](const glm::dvec3& d) { return 1 + 0.5 * d.x; };
  const Field field = make_field({{0, 0, 0}, {63, 63, 63}}, [&](glm::ivec3 voxel) {
    const glm::dvec3 p = glm::dvec3(voxel) - center;
    const double r = glm::length(p);
    return float(40 + slope(p / r) * (r - R));
  });
  Medium medium = make_medium(field, K, LuminanceSource::constant);
  medium.gradient = std::make_shared<const Field>(gradient_of_voxels(field));
  medium.transfer = std::make_shared<const TransferFunction>(
      std::vector<TransferPoint>(1), false, GradientPart{.isosurfaces = {{40, thickness, 1}}});
  const RayMedium ready(medium);
  RayIntegrator integrator(ready, 1e-12);
  double least = infinity, most = 0, least_depth = infinity, most_depth = 0;
  double least_slope = infinity, most_slope = 0;
  for (const WorldRay& out : rays_through(center - 1.0, center + 1.0, 200)) {
    const WorldRay ray{center, out.direction};
    const double s = slope(ray.direction);
    least_slope = std::min(least_slope, s);
    most_slope = std::max(most_slope, s);
    // the t at which the depth starts to grow, and at which it stops
    const auto depth = [&](double r) {
      return integrator.whole_depth(ray, R - 2 * thickness, r).optical_depth;
    };
    const double whole = depth(R + 2 * thickness);
    const auto reach = [&](double part) {
      double lo = R - 2 * thickness, hi = R + 2 * thickness;
      for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (lo + hi);
        (depth(middle) < part * whole ? lo : hi) = middle;
      }
      return hi;
    };
    // 1e-6 of a tent's depth lies in the outer sqrt(1e-6 / 2) of its width
    const double width = (reach(1 - 1e-6) - reach(1e-6)) / (1 - 2 * std::sqrt(0.5e-6));
    least = std::min(least, width);
    most = std::max(most, width);
    least_depth = std::min(least_depth, whole);
    most_depth = std::max(most_depth, whole);
  }
  std::printf("  slopes %.2f to %.2f, width %.4f to %.4f of %g, depth %.4f to %.4f of %g\n",
              least_slope, most_slope, least, most, 2 * thickness, least_depth, most_depth,
              K * thickness);
  EXPECT_GT(most_slope / least_slope, 2.5);
  // The second derivatives of v in the two directions along the shell sum to 2 s/r. Trilinear
  // interpolation therefore shifts the shell by at most 2/8 s/(R - 2) voxels [0.014] on either
  // side. The slope's own change over the sphere, 0.5/R, adds (0.5 thickness/R)^2/2 [0.001] to the
  // gradient's magnitude, and the differences add 0.2/(R - 3)^2 [0.001].
  const double off = 2 * (0.014 + thickness * (0.001 + 0.001)) * 1.5;
  EXPECT_NEAR(least, 2 * thickness, off);
  EXPECT_NEAR(most, 2 * thickness, off);
  EXPECT_NEAR(least_depth, K * thickness, K * off / 2);
  EXPECT_NEAR(most_depth, K * thickness, K * off / 2);
}

}  // namespace
}  // namespace psivox
