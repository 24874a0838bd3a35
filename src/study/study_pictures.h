#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "psivox/draw.h"
#include "psivox/legend.h"
#include "study/results.h"
#include "study/study_cost.h"

namespace psivox {

struct ComparedPicture {
  ForeignPoint point;
  Image difference;
};

/// Compares another renderer's picture with the reference of its size. An opaque picture is
/// compared with the reference over the colour, or over the radiance `behind` its pixels.
ComparedPicture compare_foreign(const ForeignPicture& foreign, const Image& picture,
                                Image reference, const glm::dvec3& color,
                                const std::vector<glm::vec3>& behind);

/// Draws the pictures of a study: of one view, in the light of the marcher that is prepared first.
class StudyPictures {
 public:
  /// `options` must outlive it.
  StudyPictures(View view, const StudyOptions& options);

  const View& view() const { return session_.view(); }
  Wish wish_of(const Variant& variant) const;
  void prepare(Marcher& by, const Variant& variant) { session_.prepare(by, wish_of(variant)); }
  Drawn draw(Marcher& by, const Wish& wish) { return session_.draw(by, wish); }
  /// The reference for the variant's resolution, which it also writes to the folder.
  const Image& reference(const Variant& variant);
  /// Times a variant. Marches on the CPU are tried with a 64th of the pixels.
  CostTrial trial(const Variant& variant);
  /// Writes the picture as `render` does, with the scene's background and exposure.
  void write_png(Image image, const Scene& scene, const std::filesystem::path& path) const;
  /// Writes the page on which the picture turns, by the method of the default tolerance. Writes
  /// none where a page cannot show the scene, or takes more than 2 MB.
  void write_turning_page();
  /// Compares with the reference of the same size, which must be there; writes both pictures.
  ForeignPoint compare(const ForeignPicture& foreign) const;

 private:
  Image make_reference(const Variant& variant);
  Legend legend(const glm::ivec2& resolution) const;

  const StudyOptions& options_;
  Session session_;
  std::map<std::string, Image> references_;  ///< by reference_name(variant)

 public:
  const Scene scene;  ///< without the parameters that the sweep sets
  const std::shared_ptr<Marcher> gpu, by_double, by_reference;
  double reference_bound = 0;  ///< of all references until now
};

}  // namespace psivox
