#pragma once

#include "base/statistics.h"
#include "march/marcher.h"
#include "medium/backdrop.h"
#include "plan/light_through.h"

namespace psivox {

/// The march that a plan chose, and the pilot that it used.
struct PlannedMarch {
  View view;                 ///< with the method chosen; its scene has no tolerance
  BrickSteps brick_steps;    ///< null: one step everywhere
  Image truth;               ///< the pilot's rays, exact in double; empty if no method was tried
  CodeWidths code_widths{};  ///< null: float32
  Backdrop behind{};         ///< the pilot's rays
  std::vector<double> through{};   ///< see light_through
  std::vector<SeenPixel> unmet{};  ///< see Trials::unmet
};

/// Finds the cheapest method for `view` whose RMS error over R G B A is at most its scene's
/// tolerance. It marches a few hundred of the picture's rays in double precision, exactly in cells
/// and by methods that may be cheaper, and compares. Any brick whose stored values allow a step to
/// miss more than a few tolerances gets a smaller step, even if no ray of the pilot meets it. The
/// result depends on the view alone, not on the machine or its threads. Light must have been
/// computed. `progress` is called with 0, often: it may throw to end the search.
MarchPlan plan_march(const View& view, const MediumAtlas& atlas, const Progress& progress = {});

/// Whether the view may be drawn by codes that are chosen for it.
bool may_be_coded(const View& view);

/// Gives the plan the coarsest codes of the density, and of the light beside it, with which the
/// pilot's rays stay within the tolerance. The atlas is of float32. The plan keeps float32 if codes
/// save less than a quarter of the texels, or if a brick needs more than 16 bits. Unless
/// `fewest_bytes`, it also keeps float32 where the picture is too small to pay for the choice and
/// memory is not scarce, and where codes of density and light save less than 45 %.
void choose_codes(MarchPlan& plan, const MediumAtlas& atlas, double tolerance, bool fewest_bytes,
                  const Progress& progress);

/// The plan that marches exactly, without a pilot.
MarchPlan exact_plan(const View& view);

/// The view by the most exact method, without early termination. Its only error is arithmetic, and
/// plan_march takes it for the truth.
View exact_view(const View& view);

/// The view of the pilot's rays: some hundreds of the picture's, spread over it.
View pilot_view(const View& view);

/// Replaces the plan's estimate by the error of the pilot's rays as the device drew them. `drawn`
/// is pilot_view of the plan's view, with its brick steps. The plan must have a pilot. Of a
/// `picture` with one ray in a pixel, the bright pixels that no ray of the pilot lets expect count
/// too, each for itself.
void confirm(MarchPlan& plan, const Image& drawn, const Image* picture = nullptr);

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
