#pragma once

#include <cstdint>

#include "psivox/image.h"

namespace psivox {

/// Difference of two pictures in some of their channels. It counts values that are NaN or Inf in
/// either picture and leaves them out.
struct Deviation {
  double rms = 0;
  double max = 0;  ///< largest absolute difference, and its pixel from the top left
  int max_x = 0, max_y = 0;
  double p99 = 0;   ///< 99 % of the absolute differences are at most this
  double mean = 0;  ///< signed
  std::uint64_t not_finite = 0;
  bool operator==(const Deviation&) const = default;
};

struct PictureError {
  Deviation radiance;  ///< over R, G and B together
  Deviation alpha;
  double rms() const;  ///< over R G B A
  bool operator==(const PictureError&) const = default;
};

/// The error a - b. Throws Error(input) if the sizes differ.
PictureError picture_error(const Image& a, const Image& b);

/// The RMS over R G B A by which rounding alone may change the picture. In float a segment rounds
/// the ray's sums by a few halves of 2^-23 of them, and the roundings of n segments add up as
/// sqrt(n): 8 * 2^-23 of the picture for 100 of them. Pictures that differ by no more cannot be
/// told apart by their method.
double rounding_rms(const Image& image);

}  // namespace psivox
