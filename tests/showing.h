#pragma once

// Whether a picture can be shown: the floors that every default picture keeps.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "image/srgb_codes.h"
#include "march_cases.h"
#include "psivox/draw.h"
#include "psivox/open.h"

namespace psivox {

/// What can be measured of whether a picture can be shown, in the light of a display.
struct Showing {
  double clipped = 0;  ///< part of the pixels brighter than white
  double mean = 0;     ///< luminance of the covered part (half opaque or glowing), Rec. 709
  double spread = 0;   ///< its standard deviation over its mean
  double extent = 0;   ///< the larger part of the frame's width or height that is covered
};

inline Showing showing(const Image& image, ToneMap curve) {
  Showing s;
  int covered = 0, left = image.width, right = -1, top = image.height, bottom = -1;
  double squares = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const auto light = [&](int channel) {
        return double(display_light(float(pixel(image, x, y, channel)), curve));
      };
      const glm::dvec3 c(light(0), light(1), light(2));
      s.clipped += std::max({c.x, c.y, c.z}) > 1;
      const double luminance = 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;
      if (pixel(image, x, y, 3) < 0.5f && luminance < 0.1) continue;
      ++covered;
      s.mean += luminance;
      squares += luminance * luminance;
      left = std::min(left, x), right = std::max(right, x);
      top = std::min(top, y), bottom = std::max(bottom, y);
    }
  s.clipped /= double(image.width) * image.height;
  if (covered == 0) return s;
  s.mean /= covered;
  s.spread = std::sqrt(std::max(squares / covered - s.mean * s.mean, 0.0)) / s.mean;
  s.extent =
      std::max(double(right - left + 1) / image.width, double(bottom - top + 1) / image.height);
  return s;
}

/// What a default picture keeps. A test that sets another bound says why beside it.
struct Floors {
  double clipped = 0.01;
  double least_mean = 0.15, most_mean = 0.6;
  double spread = 0.2;
  double least_extent = 0.2, most_extent = 0.9;
};

/// Draws a file in the look that it was given, prints what the picture shows and holds it to the
/// floors.
inline void expect_shown(const std::string& name, const LookedScene& looked,
                         const Floors& floors = {}) {
  Scene scene = looked.scene;
  scene.tolerance = 3e-3;
  const Image image = Session(make_view(scene, looked.fields)).draw(*Gpu::renderer()).image;
  const Showing s = showing(image, scene.tone_map);
  std::printf("  %-26s %-8s clipped %.3f mean %.2f spread %.2f extent %.2f\n", name.c_str(),
              looked.look.c_str(), s.clipped, s.mean, s.spread, s.extent);
  EXPECT_LE(s.clipped, floors.clipped) << name;
  EXPECT_GE(s.mean, floors.least_mean) << name;
  EXPECT_LE(s.mean, floors.most_mean) << name;
  EXPECT_GE(s.spread, floors.spread) << name;
  EXPECT_GE(s.extent, floors.least_extent) << name;
  EXPECT_LE(s.extent, floors.most_extent) << name;
}

}  // namespace psivox
