#pragma once

#include <string>

#include "study/number_format.h"

namespace psivox {

/// Builds a line of CSV. It quotes nothing: no name in a study has a comma or a quote.
class CsvLine {
 public:
  CsvLine& operator<<(const std::string& text) {
    text_ += (text_.empty() ? "" : ",") + text;
    return *this;
  }
  CsvLine& operator<<(double value) { return *this << number_text(value); }
  std::string str() const { return text_ + "\n"; }

 private:
  std::string text_;
};

}  // namespace psivox
