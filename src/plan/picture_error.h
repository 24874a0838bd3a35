#pragma once

#include "base/statistics.h"
#include "march/marcher.h"
#include "medium/backdrop.h"

namespace psivox {

/// Pixels of a picture, in an order whose every beginning is spread evenly over it.
std::vector<glm::ivec2> spread_pixels(const glm::ivec2& size, std::size_t count);

/// Error that is left when a marcher draws a view exactly: arithmetic, what the most exact method
/// leaves, and the rounding of pixels to float32. `drawn` is the marcher's picture of the exact
/// view's pilot_view; the reference is the truth.
CheckedError exact_error(const View& exact, const Image& drawn);

/// The difference of a pixel from the truth, in front of what is behind it.
glm::dvec4 seen_error(const Image& truth, const Backdrop& behind, std::size_t pixel,
                      const float* rgba);

/// Errors of a picture by pixels, over all channels, in front of what is behind it.
ErrorSum seen_errors(const Image& picture, const Image& truth, const Backdrop& behind);

/// Layer `error`: per pixel, the root-mean-square difference over R G B A between a picture and a
/// better one, combined with `common`, an error that both share. The layer's RMS is the picture's.
Layer error_layer(const Image& picture, const Image& better, const Backdrop& behind = {},
                  double common = 0);

/// The rays of the pixels that check_pixels compares.
std::vector<WorldRay> checked_rays(const View& view, const Image& picture, int pixels);

/// Session::check_error for any view.
CheckedError check_pixels(const View& view, const Image& picture, int pixels,
                          const Progress& progress = {});

}  // namespace psivox
