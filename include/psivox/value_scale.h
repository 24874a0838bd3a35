#pragma once

#include <cmath>
#include <optional>

namespace psivox {

/// What a grid's values pass through before anything reads them. Both curves are 0 at `unit` or 0,
/// and never descend, so that what is not stored stays 0.
///
/// | | scaled value |
/// |---|---|
/// | linear | v |
/// | log | log10(v / unit), at least 0 |
/// | symlog | log10(1 + \|v\| / unit), with the sign of v |
struct ValueScale {
  enum class Kind { linear, log, symlog };
  Kind kind = Kind::linear;
  /// Of log, the least value above 0; of symlog, up to where it is nearly linear. Unset: by the
  /// values.
  std::optional<double> unit{};

  bool operator==(const ValueScale&) const = default;
  bool is_linear() const { return kind == Kind::linear; }

  double scaled(double value) const {
    switch (kind) {
      case Kind::linear:
        return value;
      case Kind::log:
        return value > *unit ? std::log10(value / *unit) : 0;
      case Kind::symlog:
        break;
    }
    return std::copysign(std::log1p(std::abs(value) / *unit) / std::log(10.0), value);
  }

  /// The value that is scaled to this.
  double value_of(double scaled) const {
    switch (kind) {
      case Kind::linear:
        return scaled;
      case Kind::log:
        return *unit * std::pow(10, scaled);
      case Kind::symlog:
        break;
    }
    return std::copysign(*unit * std::expm1(std::abs(scaled) * std::log(10.0)), scaled);
  }
};

}  // namespace psivox
