#pragma once

#include <algorithm>

#include "view/picture_maker.h"

namespace psivox::view {

/// Progress of the pictures that the window asked for. Its wishes are numbered from 1.
struct PictureState {
  std::uint64_t wished = 0;   ///< the newest wish
  std::uint64_t shown = 0;    ///< the wish of the newest picture on the screen
  std::uint64_t begun = 0;    ///< the wish of the newest part of an exact picture
  std::uint64_t refined = 0;  ///< the wish whose exact pictures are complete
  double refine_ms = 0, preview_ms = 0;
  Rung rung;                            ///< of the last preview
  std::optional<double> estimated_rms;  ///< of the exact picture
  glm::dvec2 layer_range{0};            ///< values at the ends of a layer's colours
  std::string renderer;
  gl::ObjectCounts objects;  ///< of the context that draws, if they are counted

  /// Whether the newest wish is complete.
  bool complete() const { return refined && refined == wished; }

  void take(const PictureNews& news) {
    for (const PreviewPicture& picture : news.previews) {
      shown = std::max(shown, picture.number);
      rung = picture.rung;
      preview_ms = picture.ms;
    }
    for (const ExactPart& part : news.parts) begun = std::max(begun, part.number);
    if (news.estimated_rms) estimated_rms = news.estimated_rms;
    if (news.refined) {
      refined = *news.refined;
      refine_ms = news.refine_ms;
    }
    layer_range = news.layer_range.value_or(layer_range);
    if (!news.renderer.empty()) renderer = news.renderer;
    objects = news.objects;
  }
};

}  // namespace psivox::view
