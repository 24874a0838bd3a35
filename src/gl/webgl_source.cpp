#include "gl/webgl_source.h"

#include <algorithm>
#include <sstream>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/text.h"
#include "gl/shader_macros.h"
#include "gl/shader_tokens.h"

namespace psivox::gl {
namespace {

/// Names that WebGL lacks, as macros of those that it has. Its globals may not have the name of a
/// function that the language has.
Macros web_names() {
  Macros macros;
  for (const char* const name : {"samplerBuffer sampler2D", "usamplerBuffer usampler2D",
                                 "texelFetch(buffer, i) entry_of(buffer, i)", "step lattice_step"})
    macros.define(name);
  return macros;
}

ShaderSource source_of(const std::string& text) {
  ShaderSource source;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) source.add_line(line, {});
  return source;
}

/// A text with parts of it replaced.
class Rewriter {
 public:
  Rewriter(std::string text, const std::vector<std::string>& textures)
      : text_(std::move(text)), tokens_(tokens_of(text_)), textures_(textures) {
    for (const Token& token : tokens_) ++uses_[token.text];
  }

  std::string run() {
    for (std::size_t i = 0; i < tokens_.size();) i = statement(i);
    for (std::size_t i = 0; i + 3 < tokens_.size(); ++i) {
      if (at(i) == "precise") round_exactly(i);
      if (at(i) == "entry_of") read_nothing(i);
    }
    const std::size_t brace = find(main_, "{");
    replace(tokens_[brace].end(), tokens_[brace].end(), "\n" + settings_);
    std::ranges::stable_sort(edits_, {}, &Edit::first);
    std::string result;
    std::size_t from = 0;
    for (const Edit& edit : edits_) {
      result += text_.substr(from, edit.first - from) + edit.text;
      from = edit.last;
    }
    return result + text_.substr(from);
  }

 private:
  struct Edit {
    std::size_t first, last;
    std::string text;
  };

  std::string_view at(std::size_t i) const { return tokens_[i].text; }
  std::size_t find(std::size_t i, std::string_view what) const {
    while (i + 1 < tokens_.size() && at(i) != what) ++i;
    return i;
  }
  void replace(std::size_t first, std::size_t last, const std::string& with) {
    edits_.push_back({first, last, with});
  }

  /// A statement outside functions; returns where the next begins. A global that is not constant
  /// gets its value in main, which ES demands.
  std::size_t statement(std::size_t i) {
    if (at(i)[0] == '#') return i + 1;
    if (at(i) == "uniform" && at(i + 1).ends_with("sampler2D")) {
      const std::string_view name = at(i + 2);
      const std::size_t end = find(i, ";");
      if (std::ranges::find(textures_, name) != textures_.end()) return end + 1;
      missing_[name] = at(i + 1) == "sampler2D" ? "vec4(0.0)" : "uvec4(0u)";
      replace(tokens_[i].at, tokens_[end].end(), "");
      return end + 1;
    }
    std::size_t end = i, equals = 0;
    int depth = 0;
    for (; end < tokens_.size(); ++end) {
      const std::string_view text = at(end);
      if (text == "main" && depth == 0) main_ = end;
      if (text == "(" || text == "[" || text == "{") ++depth;
      if (text == ")" || text == "]" || text == "}") --depth;
      if (depth > 0) continue;
      if (text == "=" && !equals) equals = end;
      if (text == ";" || (text == "}" && at(i) != "struct")) break;
    }
    if (equals && end < tokens_.size() && at(i) != "const") set_in_main(i, equals, end);
    return end + 1;
  }

  void set_in_main(std::size_t first, std::size_t equals, std::size_t end) {
    const std::string_view name = at(first + 1);
    if (uses_[name] == 1) return replace(tokens_[first].at, tokens_[end].end(), "");
    const std::size_t from = tokens_[equals].at;
    settings_ +=
        "  " + std::string(name) + " " + text_.substr(from, tokens_[end].end() - from) + "\n";
    replace(from, tokens_[end].at, "");
  }

  /// `precise T x = a;` as `T x = exactly(a);`.
  void round_exactly(std::size_t i) {
    const std::size_t equals = find(i, "="), end = find(i, ";");
    replace(tokens_[i].at, tokens_[i + 1].at, "");
    replace(tokens_[equals].end(), tokens_[equals].end(), " exactly(");
    replace(tokens_[end].at, tokens_[end].at, ")");
  }

  /// Puts zeros in place of a look-up in a texture that is missing: WebGL promises 16, not more.
  void read_nothing(std::size_t i) {
    const auto found = missing_.find(at(i + 2));
    if (found == missing_.end()) return;
    std::size_t end = i + 1;
    for (int depth = 1; depth > 0;) {
      ++end;
      if (at(end) == "(") ++depth;
      if (at(end) == ")") --depth;
    }
    replace(tokens_[i].at, tokens_[end].end(), found->second);
  }

  const std::string text_;
  std::vector<Token> tokens_;
  std::unordered_map<std::string_view, int> uses_;
  const std::vector<std::string>& textures_;
  std::unordered_map<std::string_view, std::string> missing_;  ///< their entries, by name
  std::vector<Edit> edits_;
  std::string settings_;  ///< of globals, in main
  std::size_t main_ = 0;
};

}  // namespace

std::string webgl_name(const std::string& name) {
  return split(web_names().expanded(name), '\n').front();
}

std::string webgl_text(const ShaderSource& source, const std::vector<std::string>& textures) {
  const std::string text = reduced(source_of(web_names().expanded(source.text))).text;
  const auto body = [](const std::string& all) { return all.substr(all.find('\n') + 1); };
  return "#version 300 es\n" + body(load_shader("webgl.glsl", "", {}).text) +
         Rewriter(body(text), textures).run();
}

}  // namespace psivox::gl
