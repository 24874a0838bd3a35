#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study/results.h"
#include "study/variant.h"

namespace psivox {

/// What the trial of a variant took [s].
struct CostTrial {
  double gpu = 0, compile = 0, march = 0, reference = 0;
};

/// What the pictures of a study cost: in units of one GPU picture of a cheap variant or, after a
/// trial, in seconds. What it is made of must outlive it.
class StudyCost {
 public:
  StudyCost(const StudyOptions& options, const StudyPlan& plan, const Scene& scene)
      : options_(options), plan_(plan), scene_(scene) {}

  double references() const;             ///< all of them
  double picture(const Variant&) const;  ///< by the GPU, once
  double measuring(std::size_t i) const;
  /// Of all that these points lack.
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
