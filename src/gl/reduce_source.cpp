#include <algorithm>
#include <optional>
#include <string_view>
#include <unordered_set>

#include "gl/shader_source.h"

namespace psivox::gl {
namespace {

using Names = std::unordered_set<std::string_view>;

/// Text in which the conditional parts are decided and comments are blank; lines stay. Unset where
/// another condition than #if of a constant stands.
std::optional<std::string> decided(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  Constants defined;
  std::vector<bool> kept;  ///< of each open #if, whether the part that we are in is
  const auto keeps = [&] { return std::find(kept.begin(), kept.end(), false) == kept.end(); };
  while (!text.empty()) {
    const std::string_view all = take_line(text), line = all.substr(0, all.find("//"));
    const std::vector<Token> tokens =
        tokens_of(line.starts_with("#") ? line.substr(1) : std::string_view());
    const std::string_view word = tokens.empty() ? "" : tokens[0].text;
    const auto value = value_of(tokens, {word == "if" ? 1u : 2u, tokens.size()}, defined);
    const bool closes = word == "else" || word == "endif";
    if (word == "ifdef" || word == "ifndef" || word == "elif" || (word == "if" && !value) ||
        (closes && kept.empty()))
      return {};
    if (word == "if") kept.push_back(*value != 0);
    if (word == "else") kept.back() = !kept.back();
    if (word == "endif") kept.pop_back();
    if (word == "define" && tokens.size() == 3 && keeps() && value)
      defined[tokens[1].text] = *value;
    if (word != "if" && !closes && keeps()) result += line;
    result += '\n';
  }
  return result;
}

/// Whether every bracket is closed by one of its kind.
bool closes_brackets(std::string_view text) {
  std::string open;
  for (const Token& token : tokens_of(text)) {
    const char c = token.text[0];
    if (c == '(' || c == '[' || c == '{') open += c == '(' ? ')' : c == '[' ? ']' : '}';
    if (c != ')' && c != ']' && c != '}') continue;
    if (open.empty() || open.back() != c) return false;
    open.pop_back();
  }
  return open.empty();
}

/// A function's definition.
struct Function {
  std::string_view name;
  TokenRange all;   ///< with its type
  TokenRange body;  ///< between its braces
};

class Reducer {
 public:
  explicit Reducer(std::string text) : text_(std::move(text)), tokens_(tokens_of(text_)) {
    result_ = text_;
    erased_.resize(tokens_.size());
    find_functions();
    find_constants();
  }

  /// The text with what is left out blank; lines stay.
  std::string run() {
    for (const Function& f : functions_)
      if (!has_directives(f.body)) reduce_block(f.body);
    drop_unreached();
    return result_;
  }

 private:
  std::string_view at(std::size_t i) const {
    return i < tokens_.size() ? tokens_[i].text : std::string_view(";");
  }

  /// The token behind the one that closes what the first opens.
  std::size_t behind(std::size_t open) const {
    int depth = 0;
    for (std::size_t i = open; i < tokens_.size(); ++i) {
      if (at(i) == "(" || at(i) == "{" || at(i) == "[") ++depth;
      if ((at(i) == ")" || at(i) == "}" || at(i) == "]") && --depth == 0) return i + 1;
    }
    return tokens_.size();
  }

  bool has_directives(TokenRange r) const {
    for (std::size_t i = r.first; i < std::min(r.last, tokens_.size()); ++i)
      if (at(i)[0] == '#') return true;
    return false;
  }

  void find_functions() {
    for (std::size_t i = 1; i + 1 < tokens_.size(); ++i) {
      if (at(i) == "{") i = behind(i) - 1;
      if (at(i + 1) != "(" || !tokens_[i].is_name()) continue;
      const std::size_t brace = behind(i + 1);
      if (at(brace) != "{") continue;
      std::size_t first = i - 1;  // the type, or the IN(type) that it is
      while (first > 0 && at(first) != "(" && !tokens_[first].is_name()) --first;
      if (first > 1 && at(first - 1) == "(") first -= 2;
      functions_.push_back({at(i), {first, behind(brace)}, {brace + 1, behind(brace) - 1}});
      i = behind(brace) - 1;
    }
  }

  void find_constants() {
    for (std::size_t i = 0; i < tokens_.size(); ++i) {
      const bool derived = at(i) == "DERIVED" && at(i + 1) == "(";
      if (!derived && !(at(i) == "const" && at(i + 3) == "=")) continue;
      const std::string_view type = at(derived ? i + 2 : i + 1);
      if (type != "int" && type != "bool") continue;
      TokenRange value{derived ? i + 6 : i + 4, i};
      value.last = value.first;
      if (derived)
        value.last = behind(i + 1) - 1;
      else
        while (at(value.last) != ";") ++value.last;
      if (const auto known = value_of(tokens_, value, constants_))
        constants_[at(derived ? i + 4 : i + 2)] = *known;
    }
    // a name that functions declare too is no constant there
    for (const Function& f : functions_)
      for (std::size_t i = f.all.first; i + 1 < f.all.last; ++i)
        if (tokens_[i].is_name() && at(i) != "return" && at(i) != "else")
          if (const auto found = constants_.find(at(i + 1)); found != constants_.end())
            constants_.erase(found);
  }

  void erase(TokenRange r) {
    r.last = std::min(r.last, tokens_.size());  // of a text with faults
    if (r.empty()) return;
    for (std::size_t i = tokens_[r.first].at; i < tokens_[r.last - 1].end(); ++i)
      if (result_[i] != '\n') result_[i] = ' ';
    for (std::size_t i = r.first; i < r.last; ++i) erased_[i] = true;
  }

  /// The end of the statement that begins with that token.
  std::size_t statement_end(std::size_t i) const {
    if (at(i) == "{") return behind(i);
    if (at(i) == "for" || at(i) == "while") return statement_end(behind(i + 1));
    if (at(i) == "if") {
      const std::size_t end = statement_end(behind(i + 1));
      return at(end) == "else" ? statement_end(end + 1) : end;
    }
    while (at(i) != ";") i = at(i) == "(" || at(i) == "{" || at(i) == "[" ? behind(i) : i + 1;
    return i + 1;
  }

  /// Returns whether the block ends in a return, whatever the branches that remain.
  bool reduce_block(TokenRange r) {
    for (std::size_t i = r.first; i < r.last; i = statement_end(i))
      if (reduce_statement(i)) {
        erase({statement_end(i), r.last});
        return true;
      }
    return false;
  }

  /// Reduces the statement that begins with that token; returns whether it ends in a return.
  bool reduce_statement(std::size_t i) {
    if (at(i) == "{") return reduce_block({i + 1, behind(i) - 1});
    if (at(i) == "if") return reduce_branch(i);
    if (at(i) == "for" || at(i) == "while") reduce_statement(behind(i + 1));
    return at(i) == "return";
  }

  bool reduce_branch(std::size_t i) {
    const std::size_t then = behind(i + 1), end = statement_end(then);
    const bool has_else = at(end) == "else";
    const auto known = value_of(tokens_, {i + 2, then - 1}, constants_);
    if (!known) {
      reduce_statement(then);
      if (has_else) reduce_statement(end + 1);
      return false;
    }
    const std::size_t all = statement_end(i);
    if (*known) {
      erase({i, then});
      if (has_else) erase({end, all});
      return reduce_statement(then);
    }
    erase({i, has_else ? end + 1 : all});
    if (has_else) return reduce_statement(end + 1);
    result_[tokens_[i].at] = ';';  // it may be all that another statement holds
    return false;
  }

  /// The names in a range, those in lines of the preprocessor too.
  void collect(TokenRange r, Names& names) const {
    for (std::size_t i = r.first; i < std::min(r.last, tokens_.size()); ++i) {
      if (erased_[i]) continue;
      if (at(i)[0] == '#') {
        for (const Token& token : tokens_of(at(i).substr(1))) names.insert(token.text);
      } else {
        names.insert(at(i));
      }
    }
  }

  void drop_unreached() {
    Names wanted{"main"};
    std::size_t from = 0;
    for (const Function& f : functions_) {
      collect({from, f.all.first}, wanted);
      from = f.all.last;
    }
    collect({from, tokens_.size()}, wanted);
    std::vector<bool> reached(functions_.size());
    for (bool more = true; more;) {
      more = false;
      for (std::size_t k = 0; k < functions_.size(); ++k) {
        if (reached[k] || !wanted.contains(functions_[k].name)) continue;
        reached[k] = more = true;
        collect(functions_[k].body, wanted);
      }
    }
    for (std::size_t k = 0; k < functions_.size(); ++k)
      if (!reached[k]) erase(functions_[k].all);
  }

  std::string text_, result_;
  std::vector<Token> tokens_;
  std::vector<Function> functions_;
  Constants constants_;
  std::vector<bool> erased_;  ///< of each token
};

}  // namespace

ShaderSource reduced(const ShaderSource& source) {
  std::optional<std::string> text = decided(source.text);
  if (!text || !closes_brackets(*text)) return source;  // the driver finds the fault
  *text = Reducer(std::move(*text)).run();
  std::string_view rest = *text;
  ShaderSource result;
  for (std::size_t i = 0; !rest.empty(); ++i) {
    const std::string_view line = take_line(rest);
    if (line.find_first_not_of(' ') != std::string::npos) result.add_line(line, source.places[i]);
  }
  return result;
}

}  // namespace psivox::gl
