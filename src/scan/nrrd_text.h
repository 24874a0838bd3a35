#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "scan/byte_stream.h"

// The lines of an NRRD header: fields, words and numbers, without their meaning.

namespace psivox::scan {

/// The fields of a header by their names in lower case, without spaces: `datafile` is `data file`.
struct NrrdText {
  std::map<std::string, std::string> fields;
  std::int64_t end = 0;  ///< of the header [bytes]

  /// A field; empty if there is none.
  const std::string& of(const std::string& name) const;
};

/// Reads lines up to the first empty one, or to the end of a header whose values lie elsewhere.
/// Throws Error(input) if the header is longer than 1 MiB.
NrrdText read_nrrd_text(FileBlocks& file);

/// Words between spaces. Spaces within quotes or brackets do not separate words.
std::vector<std::string> words(std::string_view text);

/// The number that a text is. Throws Error(input) with the field if it is none.
template <typename Number>
Number number(const FileBlocks& file, const std::string& text, const char* field) {
  Number value{};
  // std::from_chars knows no plus sign
  const std::string_view digits = std::string_view(text).substr(text.starts_with('+') ? 1 : 0);
  if (!read_number(digits, value))
    refuse(file, std::string(field) + " of " + in_quotes(text) + " is no number");
  return value;
}

}  // namespace psivox::scan
