#include "base/html.h"

namespace psivox {

std::string html_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
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

static constexpr std::string_view base64_digits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

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
