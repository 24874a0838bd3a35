#include "gl/shader_source.h"

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

/// The word at the beginning of a text: a name, or a number with its point and letters.
std::string_view word_of(std::string_view text) {
  const bool name = !is_digit(text[0]);
  std::size_t end = 0;
  while (end < text.size() && (part_of_name(text[end]) || (!name && text[end] == '.'))) ++end;
  return text.substr(0, end);
}

std::size_t skip_spaces(std::string_view text, std::size_t i) {
  while (i < text.size() && is_space(text[i])) ++i;
  return i;
}

std::string trimmed(std::string_view text) {
  const std::size_t first = skip_spaces(text, 0);
  std::size_t last = text.size();
  while (last > first && is_space(text[last - 1])) --last;
  return std::string(text.substr(first, last - first));
}

/// What stands in the parentheses at `i`, by its commas. Moves `i` behind them.
std::vector<std::string> items_at(std::string_view text, std::size_t& i) {
  std::vector<std::string> items;
  std::size_t first = i + 1;
  int depth = 0;
  for (; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '(' || c == '[') ++depth;
    if (c == ')' || c == ']') --depth;
    if (depth > 0 && !(depth == 1 && c == ',')) continue;
    items.push_back(trimmed(text.substr(first, i - first)));
    first = i + 1;
    if (depth == 0) break;
  }
  ++i;
  return items;
}

/// A line without its end; goes on behind it. A line that ends in \ includes the next.
std::string take_logical_line(std::string_view& text) {
  std::string line;
  for (bool more = true; more && !text.empty();) {
    const std::string_view part = take_line(text);
    more = part.ends_with('\\');
    line += more ? std::string(part.substr(0, part.size() - 1)) + " " : std::string(part);
  }
  return line;
}

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

void Macros::define(std::string_view text) {
  const std::string name(word_of(text));
  Macro macro;
  std::size_t i = name.size();
  macro.is_function = i < text.size() && text[i] == '(';
  if (macro.is_function) macro.parameters = items_at(text, i);
  macro.body = trimmed(text.substr(i));
  macros_[name] = std::move(macro);
}

std::string Macros::expanded(std::string_view text) {
  std::string result, lines;
  const auto finish = [&] {
    result += replaced(lines, {});
    lines.clear();
  };
  while (!text.empty()) {
    const std::string line = take_logical_line(text);
    if (!line.starts_with("#")) {
      lines += line + "\n";
      continue;
    }
    finish();
    if (line.starts_with("#define "))
      define(line.substr(8));
    else if (line.starts_with("#undef "))
      macros_.erase(trimmed(line.substr(7)));
    else
      result += line + "\n";
  }
  finish();
  return result;
}

std::string Macros::replaced(std::string_view text, const Names& open) const {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    if (!part_of_name(text[i])) {
      result += text[i++];
      continue;
    }
    const std::string name(word_of(text.substr(i)));
    i += name.size();
    const auto found = macros_.find(name);
    if (found == macros_.end() || open.contains(name)) {
      result += name;
      continue;
    }
    std::vector<std::string> arguments;
    std::size_t end = skip_spaces(text, i);
    if (found->second.is_function) {
      if (end < text.size() && text[end] == '(') arguments = items_at(text, end);
      if (arguments.size() != found->second.parameters.size()) {
        result += name;
        continue;
      }
      i = end;
    }
    for (std::string& argument : arguments) argument = replaced(argument, open);
    result += call(name, found->second, arguments, open);
  }
  return result;
}

std::string Macros::call(const std::string& name, const Macro& macro,
                         const std::vector<std::string>& arguments, Names open) const {
  std::string result;
  const std::string_view body = macro.body;
  for (std::size_t i = 0; i < body.size();) {
    if (body.substr(i, 2) == "##") {
      result.erase(result.find_last_not_of(' ') + 1);
      i = skip_spaces(body, i + 2);
      continue;
    }
    if (!part_of_name(body[i])) {
      result += body[i++];
      continue;
    }
    const std::string word(word_of(body.substr(i)));
    i += word.size();
    const auto parameter = std::ranges::find(macro.parameters, word);
    const auto place = std::size_t(parameter - macro.parameters.begin());
    result += parameter == macro.parameters.end() ? word : arguments[place];
  }
  open.insert(name);
  return replaced(result, open);
}

}  // namespace psivox::gl
