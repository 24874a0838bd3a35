#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study/results.h"
#include "study/variant.h"

namespace psivox {

/// What the trial of one variant took [s].
struct CostTrial {
  double gpu = 0, compile = 0, march = 0, reference = 0;
};

/// What the pictures of a study cost: in units of one GPU picture of a cheap variant or, after a
/// trial, in seconds.
class StudyCost {
 public:
  /// All three must outlive it.
  StudyCost(const StudyOptions& options, const StudyPlan& plan, const Scene& scene)
      : options_(options), plan_(plan), scene_(scene) {}

  double references() const;             ///< all of them
  double picture(const Variant&) const;  ///< by the GPU, once
  double measuring(std::size_t i) const;
  /// Of all that these points lack.
  double left(const std::vector<std::optional<StudyPoint>>& points) const;

  /// A variant of average cost to try, if the study is worth a trial: its pictures are large.
  const Variant* typical() const;
  void take(const Variant& tried, const CostTrial& trial);
  /// How long the study takes and how it takes less, in a line; empty if it is short.
  std::string forecast() const;

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
