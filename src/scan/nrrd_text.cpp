#include "scan/nrrd_text.h"

namespace psivox::scan {
namespace {

std::string trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == text.npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(" \t") - begin + 1));
}

}  // namespace

const std::string& NrrdText::of(const std::string& name) const {
  static const std::string none;
  const auto field = fields.find(name);
  return field == fields.end() ? none : field->second;
}

NrrdText read_nrrd_text(FileBlocks& file) {
  constexpr std::int64_t longest = 1 << 20;
  ByteStream stream(file, 0);
  NrrdText text;
  stream.line();  // the magic
  while (stream.position() < file.size()) {
    if (stream.position() > longest) refuse(file, "its header has no end");
    const std::string line = stream.line();
    if (line.empty()) break;
    const auto colon = line.find(':');
    // a comment, or a key and its value, which mean something to their writer alone
    if (line[0] == '#' || colon == line.npos || line.substr(colon).starts_with(":=")) continue;
    std::string name = lower_case(line.substr(0, colon));
    std::erase(name, ' ');
    if (name == "centerings") name = "centers";
    text.fields[name] = trimmed(std::string_view(line).substr(colon + 1));
  }
  text.end = stream.position();
  return text;
}

std::vector<std::string> words(std::string_view text) {
  std::vector<std::string> all;
  std::string word;
  int depth = 0;
  bool quoted = false;
  for (const char c : std::string(text) + ' ') {
    if (c == '"') quoted = !quoted;
    if (!quoted && c == '(') ++depth;
    if (!quoted && c == ')') --depth;
    const bool space = c == ' ' || c == '\t';
    if (space && depth <= 0 && !quoted) {
      if (!word.empty()) all.push_back(word);
      word.clear();
    } else if (!space || quoted) {
      word += c;
    }
  }
  return all;
}

}  // namespace psivox::scan
