#pragma once

#include <cctype>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
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

/// Macros of the preprocessor, with ##, which GLSL ES 3.00 lacks.
class Macros {
 public:
  /// Takes what follows `#define `.
  void define(std::string_view text);

  /// A text with its macros replaced. It obeys #define and #undef, and keeps other lines of the
  /// preprocessor. A macro stands for calls of as many arguments as it has.
  std::string expanded(std::string_view text);

 private:
  struct Macro {
    bool is_function = false;
    std::vector<std::string> parameters;
    std::string body;
  };
  using Names = std::set<std::string, std::less<>>;

  /// Replaces macros but those that are open.
  std::string replaced(std::string_view text, const Names& open) const;
  std::string call(const std::string& name, const Macro& macro,
                   const std::vector<std::string>& arguments, Names open) const;

  std::map<std::string, Macro, std::less<>> macros_;
};

}  // namespace psivox::gl
