#pragma once

#include <cstddef>
#include <functional>

#include "survey.h"

namespace psivox::vdb {

/// A leaf of a grid of any type.
class DecodedLeaf {
 public:
  explicit DecodedLeaf(const LeafMask& mask) : mask_(mask) {}

  const LeafMask& active() const { return mask_; }
  /// Copies 512 * channels values, vectors interleaved.
  virtual void copy_to(float* values) const = 0;
  virtual void copy_to(double* values) const = 0;

 protected:
  ~DecodedLeaf() = default;

 private:
  const LeafMask& mask_;
};

/// What becomes of a leaf, by its number. Several threads call it.
using TakeLeaf = std::function<void(std::size_t n, const DecodedLeaf& leaf)>;

/// A leaf whose values are computed from `value_of(i)`.
template <typename ValueOf>
class MadeLeaf final : public DecodedLeaf {
 public:
  MadeLeaf(const LeafMask& mask, ValueOf value_of) : DecodedLeaf(mask), value_of_(value_of) {}

  void copy_to(float* values) const override { copy(values); }
  void copy_to(double* values) const override { copy(values); }

 private:
  template <typename Number>
  void copy(Number* values) const {
    for (std::size_t i = 0; i < kLeafVoxels; ++i) values[i] = static_cast<Number>(value_of_(i));
  }

  ValueOf value_of_;
};

}  // namespace psivox::vdb
