#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace psivox::gl {

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
