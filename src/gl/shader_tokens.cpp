#include "gl/shader_tokens.h"

#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <string>

namespace psivox::gl {
namespace {

// of ASCII, whatever the locale, and without a call
bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool part_of_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c) || c == '_';
}

class Evaluator {
 public:
  Evaluator(const std::vector<Token>& tokens, const Constants& constants)
      : tokens_(tokens), constants_(constants) {}

  std::optional<long> operator()(TokenRange r) const {
    while (!r.empty() && at(r.first) == "(" && closing(r.first, r.last) == r.last - 1)
      r = {r.first + 1, r.last - 1};
    if (r.empty() || find(r, {"?", "="})) return {};
    if (const auto split = find(r, {"||"})) return either(r, *split, 1);
    if (const auto split = find(r, {"&&"})) return either(r, *split, 0);
    if (const auto split = find(r, {"==", "!=", "<", ">", "<=", ">="})) return compare(r, *split);
    if (at(r.first) == "!") {
      const auto value = (*this)({r.first + 1, r.last});
      if (value) return !*value;
      return {};
    }
    if (r.last - r.first == 1) return atom(at(r.first));
    return {};
  }

 private:
  std::string_view at(std::size_t i) const { return tokens_[i].text; }

  std::optional<long> atom(std::string_view text) const {
    if (text == "true") return 1;
    if (text == "false") return 0;
    if (std::all_of(text.begin(), text.end(), is_digit)) return std::stol(std::string(text));
    const auto found = constants_.find(text);
    if (found == constants_.end()) return {};
    return found->second;
  }

  /// The value of A || B, which is `decided` 1 where either side is; of A && B with 0.
  std::optional<long> either(TokenRange r, std::size_t split, long decided) const {
    const auto left = (*this)({r.first, split}), right = (*this)({split + 1, r.last});
    if ((left && bool(*left) == bool(decided)) || (right && bool(*right) == bool(decided)))
      return decided;
    if (left && right) return !decided;
    return {};
  }

  std::optional<long> compare(TokenRange r, std::size_t split) const {
    const auto a = (*this)({r.first, split}), b = (*this)({split + 1, r.last});
    if (!a || !b) return {};
    const std::string_view op = at(split);
    if (op == "==") return *a == *b;
    if (op == "!=") return *a != *b;
    if (op == "<") return *a < *b;
    if (op == ">") return *a > *b;
    return op == "<=" ? *a <= *b : *a >= *b;
  }

  /// The first of some operators outside parentheses.
  std::optional<std::size_t> find(TokenRange r, std::initializer_list<std::string_view> ops) const {
    int depth = 0;
    for (std::size_t i = r.first; i < r.last; ++i) {
      if (at(i) == "(" || at(i) == "[") ++depth;
      if (at(i) == ")" || at(i) == "]") --depth;
      if (depth == 0 && std::find(ops.begin(), ops.end(), at(i)) != ops.end()) return i;
    }
    return {};
  }

  std::size_t closing(std::size_t open, std::size_t last) const {
    int depth = 0;
    for (std::size_t i = open; i < last; ++i) {
      if (at(i) == "(") ++depth;
      if (at(i) == ")" && --depth == 0) return i;
    }
    return last;
  }

  const std::vector<Token>& tokens_;
  const Constants& constants_;
};

}  // namespace

std::vector<Token> tokens_of(std::string_view text) {
  std::vector<Token> tokens;
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i + 1;
    if (is_space(text[i])) {
      ++i;
      continue;
    }
    if (text[i] == '#') {
      while (end < text.size() && (text[end] != '\n' || text[end - 1] == '\\')) ++end;
    } else if (part_of_name(text[i])) {
      while (end < text.size() && (part_of_name(text[end]) || text[end] == '.')) {
        if (text[end] == '.' && !is_digit(text[i])) break;
        ++end;
      }
    } else if (end < text.size()) {
      constexpr std::string_view pairs[] = {"==", "!=", "<=", ">=", "&&", "||"};
      if (std::find(std::begin(pairs), std::end(pairs), text.substr(i, 2)) != std::end(pairs))
        ++end;
    }
    tokens.push_back({text.substr(i, end - i), i});
    i = end;
  }
  return tokens;
}

std::optional<long> value_of(const std::vector<Token>& tokens, TokenRange range,
                             const Constants& constants) {
  return Evaluator(tokens, constants)(range);
}

}  // namespace psivox::gl
