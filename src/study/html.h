#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace psivox {

/// A whole page with its style, and with the scripts of its plots if it has any. `title` is text,
/// `body` is HTML.
std::string html_page(const std::string& title, const std::string& body);

/// The first row is the head. Cells are HTML: words are left-aligned and wrap, numbers are
/// right-aligned.
enum class Cells { numbers, words };
std::string html_table(const std::vector<std::vector<std::string>>& rows,
                       Cells cells = Cells::numbers);

/// A PNG inside the page, at most `width` pixels wide, above a line of HTML; the line alone if
/// there is no such file. Plots show the figure beside the points with the name `variant`.
std::string html_figure(const std::filesystem::path& png, const std::string& caption, int width,
                        const std::string& variant = "");

}  // namespace psivox
