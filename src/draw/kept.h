#pragma once

#include <memory>

namespace psivox {

/// What a stage has made last, kept by the key of all that it was made from.
template <typename Key, typename Made>
class Kept {
 public:
  /// Makes it, unless it is kept for this key. What is kept for another key goes before.
  const std::shared_ptr<Made>& of(const Key& key, const auto& make) {
    if (made_ && key_ == key) return made_;
    forget();
    made_ = std::make_shared<Made>(make());
    key_ = key;
    return made_;
  }
  const std::shared_ptr<Made>& get() const { return made_; }
  void forget() { made_.reset(); }

 private:
  Key key_{};
  std::shared_ptr<Made> made_;
};

}  // namespace psivox
