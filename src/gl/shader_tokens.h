#pragma once

#include <cctype>
#include <cstddef>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace psivox::gl {

struct Token {
  std::string_view text;
  std::size_t at = 0;  ///< first character in the source
  std::size_t end() const { return at + text.size(); }
  bool is_name() const { return std::isalpha(text[0]) || text[0] == '_'; }
};

/// From the first token to before the last.
struct TokenRange {
  std::size_t first = 0, last = 0;
  bool empty() const { return first >= last; }
};

/// Tokens of a text without comments. Lines of the preprocessor are one token each.
std::vector<Token> tokens_of(std::string_view text);

using Constants = std::unordered_map<std::string_view, long>;

/// The value of a constant expression: of !, comparisons, && and ||. Other expressions have none.
std::optional<long> value_of(const std::vector<Token>& tokens, TokenRange range,
                             const Constants& constants);

}  // namespace psivox::gl
