#pragma once

#include <cstdio>
#include <string>
#include <string_view>

namespace psivox {

/// Writes text, of which terminals see no control character but line breaks and tabs. Every text
/// that the program prints goes through here: a file's author may have written a part of it.
void print(std::FILE* to, std::string_view text);

/// Prints "psivox: NOTICE" to stderr, as one line.
void print_notice(std::string_view notice);

/// From now on std::cout prints through print().
void print_standard_output_safely();

}  // namespace psivox
