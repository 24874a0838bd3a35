#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "psivox/draw.h"
#include "psivox/legend.h"
#include "study/foreign.h"
#include "study/results.h"
#include "study/study_cost.h"

namespace psivox {

/// Draws the pictures of a study: of one view, in the light that the reference computes.
class StudyPictures {
 public:
  /// `options` must outlive it.
  StudyPictures(View view, const StudyOptions& options);

  const View& view() const { return session_.view(); }
  const Scene& scene() const { return scene_; }  ///< without the parameters that the sweep sets
  std::string renderer() const { return description(*gpu_); }
  double reference_bound() const { return reference_bound_; }  ///< of all references until now

  Wish wish_of(const Variant& variant) const;
  /// Atlas and light, by the reference or by the GPU.
  void prepare_light(const Variant& variant) { session_.prepare(*reference_, wish_of(variant)); }
  void prepare(const Variant& variant) { session_.prepare(*gpu_, wish_of(variant)); }

  Drawn draw(const Wish& wish) { return session_.draw(*gpu_, wish); }
  Image exact(const Wish& wish) { return session_.draw(*double_, wish).image; }
  /// The reference for the variant's resolution, which it also writes to the folder: as an earlier
  /// run of the study left it, or drawn. The bound always comes from the layer as saved, so both
  /// cases give the same bound.
  const Image& reference(const Variant& variant);

  /// Times a variant. Marches on the CPU are tried with a 64th of the pixels.
  CostTrial trial(const Variant& variant);

  /// Writes the picture as `render` does, with the scene's background and exposure.
  void write_png(Image image, const Scene& scene, const std::filesystem::path& path) const;

  /// Compares another renderer's picture with the reference of its size and writes both pictures;
  /// the references must be there.
  ForeignPoint compare(const ForeignPicture& foreign) const;

  void stop_if_asked() const;

 private:
  Image make_reference(const Variant& variant);
  Legend legend(const glm::ivec2& resolution) const;

  const StudyOptions& options_;
  Session session_;
  Scene scene_;
  std::shared_ptr<Marcher> gpu_, double_, reference_;
  std::map<std::string, Image> references_;  ///< by reference_name(variant)
  double reference_bound_ = 0;
};

}  // namespace psivox
