#include "base/terminal.h"

#include <iostream>
#include <streambuf>

#include "base/text.h"

namespace psivox {
namespace {

class SafeOutput final : public std::streambuf {
 protected:
  std::streamsize xsputn(const char* text, std::streamsize size) override {
    print(stdout, {text, std::size_t(size)});
    return std::ferror(stdout) ? 0 : size;
  }
  int_type overflow(int_type letter) override {
    const char c = traits_type::to_char_type(letter);
    if (traits_type::eq_int_type(letter, traits_type::eof())) return traits_type::not_eof(letter);
    return xsputn(&c, 1) == 1 ? letter : traits_type::eof();
  }
  int sync() override { return std::fflush(stdout) == 0 && !std::ferror(stdout) ? 0 : -1; }
};

}  // namespace

void print(std::FILE* to, std::string_view text) {
  std::string safe;
  for (std::size_t length = 1; !text.empty(); text.remove_prefix(length)) {
    const Letter letter = first_letter(text);
    length = letter.bytes;
    if (letter.code == '\n' || letter.code == '\t' ||
        (letter.code != no_letter && !controls_terminals(letter.code)))
      safe += text.substr(0, length);
    else if (letter.code == no_letter)
      safe += printable(text.substr(0, 1));
    else
      safe += formatted("\\u%04x", unsigned(letter.code));  // which JSON reads back
  }
  std::fwrite(safe.data(), 1, safe.size(), to);
}

void print_notice(std::string_view notice) { print(stderr, "psivox: " + printable(notice) + "\n"); }

void print_standard_output_safely() {
  static auto* const output = new SafeOutput;  // std::cout is flushed after all else has ended
  std::cout.rdbuf(output);
}

}  // namespace psivox
