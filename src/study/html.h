#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace psivox {

/// A whole page with its style; `title` is text, `body` HTML.
std::string html_page(const std::string& title, const std::string& body);

/// The first row is the head; cells are HTML. Words, unlike numbers, stand at the left and wrap.
enum class Cells { numbers, words };
std::string html_table(const std::vector<std::vector<std::string>>& rows,
                       Cells cells = Cells::numbers);

/// A PNG inside the page, at most `width` pixels wide, with a line of HTML below; the line alone
/// where there is no such file.
std::string html_figure(const std::filesystem::path& png, const std::string& caption, int width);

}  // namespace psivox
