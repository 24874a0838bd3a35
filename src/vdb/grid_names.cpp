#include "vdb/grid_names.h"

#include <algorithm>
#include <cctype>

#include "base/text.h"

namespace psivox {
namespace {

bool is(int (*kind)(int), char c) { return kind(static_cast<unsigned char>(c)) != 0; }

/// Whether a word begins at a letter or digit behind another: `fogDensity`, `FOGDensity`, `grid2`.
bool begins_word(std::string_view name, std::size_t i) {
  if (is(std::isdigit, name[i]) != is(std::isdigit, name[i - 1])) return true;
  if (!is(std::isupper, name[i])) return false;
  const bool lower_follows = i + 1 < name.size() && is(std::islower, name[i + 1]);
  return is(std::islower, name[i - 1]) || (is(std::isupper, name[i - 1]) && lower_follows);
}

constexpr std::array solver_words{"shadow", "pressure", "p", "uvgrid", "uv", "react"};

}  // namespace

std::vector<std::string> name_words(std::string_view grid) {
  std::vector<std::string> words;
  bool inside = false;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const bool part = is(std::isalnum, grid[i]);
    if (part && (!inside || begins_word(grid, i))) words.emplace_back();
    if (part) words.back() += lower_case(grid.substr(i, 1));
    inside = part;
  }
  while (words.size() > 1 && is(std::isdigit, words.back()[0])) words.pop_back();
  return words;
}

Saying saying(std::string_view grid, std::string_view word) {
  const auto means = [&](std::string_view text) {
    if (text.ends_with('s') && !word.ends_with('s')) text.remove_suffix(1);
    return text == word;
  };
  const std::vector<std::string> words = name_words(grid);
  if (words.empty()) return Saying::not_at_all;
  if (means(joined(words, ""))) return Saying::whole;
  return means(words.back()) ? Saying::at_its_end : Saying::not_at_all;
}

bool says_density(std::string_view grid) {
  return std::ranges::any_of(
      density_words, [&](const char* word) { return saying(grid, word) != Saying::not_at_all; });
}

bool is_of_solver(std::string_view grid) {
  const std::vector<std::string> words = name_words(grid);
  if (words.empty()) return false;
  return words.front() == "phi" || words.front() == "uv" ||
         std::ranges::count(solver_words, words.back()) > 0 ||
         std::ranges::count(solver_words, joined(words, "")) > 0;
}

std::string grid_saying(const VolumeFile& file, std::string_view word, int channels) {
  for (const Saying how : {Saying::whole, Saying::at_its_end})
    for (const std::string& grid : file.names())
      if (saying(grid, word) == how && file.channels(grid) == channels) return grid;
  return {};
}

}  // namespace psivox
