#include "base/text.h"

#include <algorithm>
#include <cctype>
#include <cstdarg>
#include <cstdio>
#include <numeric>

namespace psivox {
namespace {

constexpr std::string_view base64_digits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::string folded(std::string_view name) {
  std::string out = lower_case(name);
  std::ranges::replace(out, '_', '-');
  return out;
}

/// Optimal string alignment distance: Levenshtein's, with a swap of neighbours as one edit.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last, last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    before_last = last;
    last.swap(row);
  }
  return last[b.size()];
}

}  // namespace

Letter first_letter(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  const std::size_t length = first < 0x80 ? 1 : first >> 5 == 6 ? 2 : first >> 4 == 14 ? 3 : 4;
  if (length == 1) return {1, char32_t(first)};
  char32_t code = first & (0x7fu >> length);
  bool valid = length <= text.size() && first < 0xf8 && first >= 0xc0;
  for (std::size_t i = 1; valid && i < length; ++i) {
    valid = byte(i) >> 6 == 2;
    code = code << 6 | (byte(i) & 0x3f);
  }
  constexpr char32_t least[] = {0x80, 0x800, 0x10000};  // of 2, 3 and 4 bytes
  if (!valid || code < least[length - 2] || code > 0x10ffff || code >> 11 == 0xd800 >> 11)
    return {1, no_letter};
  return {length, code};
}

namespace {

constexpr char32_t first_byte = 0xf700;
bool is_byte(char32_t letter) { return letter >= first_byte + 0x80 && letter <= first_byte + 0xff; }

}  // namespace

std::string utf8_of_bytes(std::string_view bytes) {
  std::string out;
  for (std::size_t length = 1; !bytes.empty(); bytes.remove_prefix(length)) {
    const Letter letter = first_letter(bytes);
    length = letter.bytes;
    if (letter.code != no_letter && !is_byte(letter.code)) {
      out += bytes.substr(0, length);
      continue;
    }
    length = 1;
    const unsigned code = first_byte + static_cast<unsigned char>(bytes[0]);
    for (const unsigned byte : {0xe0 | code >> 12, 0x80 | (code >> 6 & 0x3f), 0x80 | (code & 0x3f)})
      out += char(byte);
  }
  return out;
}

std::string bytes_of_utf8(std::string_view text) {
  std::string out;
  for (; !text.empty(); text.remove_prefix(first_letter(text).bytes)) {
    const Letter letter = first_letter(text);
    if (is_byte(letter.code))
      out += char(letter.code - first_byte);
    else
      out += text.substr(0, letter.bytes);
  }
  return out;
}

bool controls_terminals(char32_t code) {
  return code < 0x20 || (code >= 0x7f && code < 0xa0) || (code >= 0x2028 && code <= 0x202e) ||
         (code >= 0x2066 && code <= 0x2069);
}

std::string printable(std::string_view text) {
  std::string out;
  for (std::size_t length = 1; !text.empty(); text.remove_prefix(length)) {
    const Letter letter = first_letter(text);
    length = letter.bytes;
    if (letter.code == no_letter || (letter.code < 0x80 && controls_terminals(letter.code)))
      out += formatted("\\x%02x", static_cast<unsigned char>(text[0]));
    else if (controls_terminals(letter.code))
      out += formatted("\\u%04x", unsigned(letter.code));
    else
      out += text.substr(0, length);
  }
  return out;
}

std::string shell_word(std::string_view text) {
  constexpr std::string_view plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./,:=+@%";
  if (!text.empty() && text[0] != '=' && text.find_first_not_of(plain) == text.npos)
    return std::string(text);
  const bool controls = printable(text) != text;
  std::string out = controls ? "$'" : "'";
  while (!text.empty()) {
    const Letter letter = first_letter(text);
    if (letter.code == no_letter || controls_terminals(letter.code))
      for (const char byte : text.substr(0, letter.bytes))
        out += formatted("\\%03o", static_cast<unsigned char>(byte));
    else if (text[0] == '\'')
      out += controls ? "\\'" : "'\\''";
    else if (text[0] == '\\' && controls)
      out += "\\\\";
    else
      out += text.substr(0, letter.bytes);
    text.remove_prefix(letter.bytes);
  }
  return out + "'";
}

std::string in_quotes(std::string_view text) { return "'" + printable(text) + "'"; }

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> items;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(separator), text.size());
    items.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return items;
}

std::string joined(std::span<const std::string> items, std::string_view between) {
  std::string out;
  for (const std::string& item : items) {
    if (&item != &items.front()) out += between;
    out += item;
  }
  return out;
}

std::string nearest_name(std::string_view name, std::span<const std::string> candidates) {
  const std::string wanted = folded(name);
  // A prefix of only one name: --camera-pos.
  const auto begins = [&](const std::string& candidate) { return candidate.starts_with(wanted); };
  if (std::count_if(candidates.begin(), candidates.end(), begins) == 1 && !wanted.empty())
    return *std::find_if(candidates.begin(), candidates.end(), begins);

  const auto distance = [&](const std::string& candidate) {
    return edit_distance(wanted, folded(candidate));
  };
  const auto nearest = std::ranges::min_element(candidates, {}, distance);
  // A third of the letters may be wrong; with more, a suggestion misleads.
  const std::size_t most = std::max<std::size_t>(wanted.size(), 3) / 3;
  return nearest != candidates.end() && distance(*nearest) <= most ? *nearest : "";
}

std::vector<std::string> nearest_first(std::string_view name,
                                       std::span<const std::string> candidates) {
  const std::string wanted = folded(name);
  std::vector<std::string> names(candidates.begin(), candidates.end());
  std::ranges::stable_sort(names, {}, [&](const std::string& candidate) {
    const std::string known = folded(candidate);
    const bool part =
        !known.empty() && !wanted.empty() &&
        (known.find(wanted) != std::string::npos || wanted.find(known) != std::string::npos);
    return part ? 0 : edit_distance(wanted, known);
  });
  return names;
}

std::string suggestion(std::string_view name, std::span<const std::string> candidates) {
  const std::string nearest = nearest_name(name, candidates);
  return nearest.empty() ? "" : "; did you mean " + nearest + "?";
}

std::string lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

std::string formatted(const char* pattern, ...) {
  va_list values, again;
  va_start(values, pattern);
  va_copy(again, values);
  std::string out(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, pattern, values)), '\0');
  std::vsnprintf(out.data(), out.size() + 1, pattern, again);
  va_end(again);
  va_end(values);
  return out;
}

std::string percent_text(double share) {
  return formatted(share < 0.1 ? "%.2g %%" : "%.0f %%", 100 * share);
}

std::string mebibytes(std::uint64_t bytes) {
  return formatted("%.2f MiB", static_cast<double>(bytes) / (1 << 20));
}

std::string html_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (c == '\'')
      out += "&#39;";
    else
      out += c;
  }
  return out;
}

std::string without_tags(std::string json) {
  for (std::size_t i = 0; (i = json.find('<', i)) != std::string::npos;)
    json.replace(i, 1, "\\u003c");
  return json;
}

std::string base64(std::string_view bytes) {
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  const auto byte = [&](std::size_t i) {
    return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0u;
  };
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const unsigned three = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    out += base64_digits[three >> 18];
    out += base64_digits[three >> 12 & 63];
    out += i + 1 < bytes.size() ? base64_digits[three >> 6 & 63] : '=';
    out += i + 2 < bytes.size() ? base64_digits[three & 63] : '=';
  }
  return out;
}

std::string from_base64(std::string_view text) {
  std::string bytes;
  std::size_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const std::size_t digit = base64_digits.find(c);
    if (digit == base64_digits.npos) break;
    bits = bits << 6 | digit;
    if ((count += 6) < 8) continue;
    count -= 8;
    bytes += char(bits >> count & 0xff);
  }
  return bytes;
}

}  // namespace psivox
