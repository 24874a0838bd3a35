#pragma once

#include <algorithm>
#include <cmath>

/// What each part of a picture may miss of its tolerance E. What light and march miss adds up in
/// quadrature, and so does what the parts of the light miss.
namespace psivox::budget {

// --- light, of E
/// Of lights alone, and of light with a sky, which takes far longer than the march.
inline constexpr double lights = 0.5, sky = 0.85;
/// Part of a sky's light that the lights beside it may miss: they take little time.
inline constexpr double beside_sky = 0.4;
/// Part of that which a light may be estimated to miss: its pilot is a sample.
inline constexpr double light_safety = 0.8;
/// A lattice is tried only if its expected error is at most this part of what will do: computing
/// one in vain costs more than columns closer than needed.
inline constexpr double light_sure = 0.75;
/// Rays that are exact end at this part of what the light may miss.
inline constexpr double light_rays_end = 0.5;

// --- the march, of what the light leaves
/// How much a brick that no ray of the pilot meets may miss, by its bound. The second value is for
/// bricks that keep narrower steps than they must, so that the step elsewhere can be wider.
inline constexpr double worst_brick = 64, narrow_brick = 16;

/// What a method may miss on the pilot's rays.
struct Limits {
  double rms, max;  ///< `max`: of one ray

  double excess(double of_rms, double of_max) const { return std::max(of_rms / rms, of_max / max); }
  bool keeps(double of_rms, double of_max) const { return excess(of_rms, of_max) <= 1; }
};

/// The pilot is a sample; the worst of its rays is about what one pixel in a thousand exceeds.
inline Limits march(double left) { return {0.8 * left, 4 * left}; }
/// With codes: a method may take nearly all that any may, and codes a little more.
inline Limits coded(double left) { return {0.85 * left, 4.5 * left}; }

/// In the first trial of codes, how much a step of code changes a voxel's optical depth times the
/// light there, and light, at most. Errors of a ray's voxels are independent where values vary by
/// more than a step. Inside a smooth cloud they do not, and a row of a brick is off by up to four
/// steps. One pixel in a thousand is to be off by 5 E at most: in 80 pictures it was off by 4.5 E
/// at 8, and by 5.6 E at 9.7. At 6.8 the error of smoke at 1e-3 jumps by 0.18 E at brick borders in
/// the mean, at 8 by 0.22 E, where all borders that rays cross are in line.
inline constexpr double code_depth = 6.8, code_light = 10.2;

/// What is left beside a part that misses so much, in quadrature; all if it misses more.
inline double beside(double missed, double all) {
  return missed < all ? std::sqrt(all * all - missed * missed) : all;
}

// --- pictures beside the picture, of what it may miss
/// What a ray of a deep picture leaves out where it ends.
inline constexpr double deep_end = 1.0 / 64;
/// The light with which `--aov error` compares: its own error changes the estimate by 3 %.
inline constexpr double better_light = 1.0 / 4;

}  // namespace psivox::budget
