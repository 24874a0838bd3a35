#pragma once

#include <charconv>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace psivox {

/// A letter of UTF-8.
struct Letter {
  std::size_t bytes;
  char32_t code;
};
inline constexpr char32_t no_letter = ~char32_t{0};  ///< of a byte that begins none

/// The first letter of a text that is not empty.
Letter first_letter(std::string_view text);

/// Bytes as UTF-8, which JSON must be: each that is none, as in names of files, becomes the letter
/// U+F700 + byte, of those for private use. Such a letter counts as bytes, too.
std::string utf8_of_bytes(std::string_view bytes);
/// The bytes again.
std::string bytes_of_utf8(std::string_view text);

/// Whether terminals act on it: controls (C0, DEL, C1), and what breaks or turns lines.
bool controls_terminals(char32_t code);

/// Text of a file as one line for a terminal: what controls it is escaped, as \x1b or \u009b, and
/// so are bytes that are no UTF-8.
std::string printable(std::string_view text);

/// `text` in single quotes, with control characters escaped, for a message of one line.
std::string in_quotes(std::string_view text);

/// The items between separators; an empty text has none.
std::vector<std::string> split(std::string_view text, char separator = ',');

std::string joined(std::span<const std::string> items, std::string_view between = ",");

/// What `text` takes of each row of a table: names_in(rows, &Row::name).
template <typename Rows, typename Text>
std::vector<std::string> names_in(const Rows& rows, Text text) {
  std::vector<std::string> names;
  for (const auto& row : rows) names.emplace_back(std::invoke(text, row));
  return names;
}

/// The candidate with the smallest edit distance (a letter inserted, dropped or changed, or two
/// neighbours swapped); empty if none is near. It ignores case, and `_` is `-`.
std::string nearest_name(std::string_view name, std::span<const std::string> candidates);

/// The candidates by rising edit distance, those first that are a part of the name or have it as
/// one; otherwise in their order.
std::vector<std::string> nearest_first(std::string_view name,
                                       std::span<const std::string> candidates);

/// "; did you mean X?", or empty if no candidate is near.
std::string suggestion(std::string_view name, std::span<const std::string> candidates);

/// With ASCII letters in lower case.
std::string lower_case(std::string_view text);

/// Formats text like printf.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* pattern, ...);

/// "34 %" of 0.34, with two digits at least.
std::string percent_text(double share);

/// "1.50 MiB".
std::string mebibytes(std::uint64_t bytes);

/// `text` as one word of a shell, in quotes where it needs them. It is safe to paste and to print:
/// what controls a terminal is escaped in bash's $'...'.
std::string shell_word(std::string_view text);

/// A text with &, <, > and quotes escaped, for HTML and SVG.
std::string html_text(std::string_view text);

/// JSON for an element of HTML, which a `<` could end.
std::string without_tags(std::string json);

/// RFC 4648, with `=`, as in a `data:` address.
std::string base64(std::string_view bytes);
/// The bytes of such a text, up to the first character that is none of its digits.
std::string from_base64(std::string_view text);

/// The shortest digits that read back as the same number of that type.
template <typename Number>
std::string number_text(Number value) {
  char buffer[40];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

/// Whether the whole text is a number of that type; if so, sets `value`.
template <typename Number>
bool read_number(std::string_view text, Number& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

}  // namespace psivox
