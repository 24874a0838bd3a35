#pragma once

#include <string>
#include <string_view>

namespace psivox {

/// A text with &, < and > escaped, for HTML and SVG.
std::string html_text(std::string_view text);

/// JSON for an element of HTML, which a `<` could end.
std::string without_tags(std::string json);

/// RFC 4648, with `=`, as in a `data:` address.
std::string base64(std::string_view bytes);
/// The bytes of such a text, up to the first character that is none of its digits.
std::string from_base64(std::string_view text);

}  // namespace psivox
