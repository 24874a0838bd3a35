#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "psivox/draw.h"
#include "psivox/picture_file.h"
#include "study/results.h"

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

/// What the trial of a variant took [s].
struct CostTrial {
  double gpu = 0, compile = 0, march = 0, reference = 0;
};

/// Draws the pictures of a study: of one view, in the light of the marcher that is prepared first.
class StudyPictures {
 public:
  /// `options` must outlive it.
  StudyPictures(View view, const StudyOptions& options);

  Wish wish_of(const Variant& variant) const;
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
  std::map<std::string, Image> references_;  ///< by reference_name(variant)

 public:
  Session session;
  const Scene scene;  ///< without the parameters that the sweep sets
  const std::shared_ptr<Marcher> gpu, by_double, by_reference;
  double reference_bound = 0;  ///< of all references until now
};

/// The cost of a study's pictures: in units of one GPU picture of a cheap variant, and in seconds
/// after forecast(). The constructor's arguments must outlive it.
class StudyCost {
 public:
  StudyCost(const StudyOptions& options, const StudyPlan& plan, const Scene& scene)
      : options_(options), plan_(plan), scene_(scene) {}

  double references() const;             ///< all of them
  double picture(const Variant&) const;  ///< by the GPU, once
  double measuring(std::size_t i) const;
  /// The cost of what these points still lack.
  double left(const std::vector<std::optional<StudyPoint>>& points) const;
  /// How long the study takes and how it takes less, in a line; empty if it is short.
  std::string forecast(const Variant& tried, const CostTrial& trial);

 private:
  double pixels(const Variant&) const;  ///< over those of the scene's picture

  const StudyOptions& options_;
  const StudyPlan& plan_;
  const Scene& scene_;
  double unit_ = 1, reference_ = 10;
  double compile_ = 10;  ///< two programs, one of which counts
  double march_ = 10;    ///< the march in double, relative to the GPU
};

}  // namespace psivox
