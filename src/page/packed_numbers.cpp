#include "page/page_parts.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "atlas/atlas.h"
#include "base/text.h"
#include "psivox/error.h"

namespace psivox {
namespace {

std::string deflated(std::string bytes) {
  z_stream stream{};
  std::string result;
  // numbers are near 0, or noise: Z_FILTERED looks for fewer repeats
  bool fine =
      deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, MAX_WBITS, 9, Z_FILTERED) == Z_OK;
  if (fine) {
    result.resize(deflateBound(&stream, uLong(bytes.size())));
    stream.next_in = reinterpret_cast<Bytef*>(bytes.data());
    stream.avail_in = uInt(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(result.data());
    stream.avail_out = uInt(result.size());
    fine = deflate(&stream, Z_FINISH) == Z_STREAM_END;
    result.resize(stream.total_out);
    deflateEnd(&stream);
  }
  if (!fine) throw Error(ExitCode::failure, "the page's numbers cannot be compressed");
  return result;
}

/// The numbers as the page holds them: their first bytes, then their second ones, ..., deflated.
/// Neighbours are alike in their high bytes, which deflates to less.
std::string packed(std::string_view bytes, std::size_t size) {
  const std::size_t count = bytes.size() / size;
  std::string planes(bytes.size(), '\0');
  for (std::size_t k = 0; k < size; ++k)
    for (std::size_t i = 0; i < count; ++i) planes[k * count + i] = bytes[i * size + k];
  return base64(deflated(std::move(planes)));
}

template <typename T>
std::string packed(const std::vector<T>& numbers) {
  return packed({reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T)},
                sizeof(T));
}

/// A channel's codes in a brick (CodeWidth) as what the seven corners before each voxel do not
/// tell, which is 0 where values are trilinear: 0, -1, 1, -2, ... as 0, 1, 2, 3, ..., in the high
/// bits.
void add_differences(const std::uint64_t* words, int channels, int wide,
                     std::vector<std::uint16_t>& all) {
  const int last = (1 << wide) - 1;
  const int bits = std::array{7, 12, 16}[std::size_t(wide)], cells = brick_cells >> wide;
  const std::uint32_t mask = (1u << bits) - 1;
  constexpr std::size_t n = brick_values;
  std::array<std::uint32_t, brick_texels> codes;
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const int row = int(i) / brick_values, z = int(i) % brick_values;
    const int word = std::min(z / cells, last);
    codes[i] =
        std::uint32_t(words[channels * ((row << wide) + word)] >> (bits * (z - word * cells))) &
        mask;
  }
  for (const std::size_t stride : {std::size_t{1}, n, n * n})
    for (std::size_t i = codes.size(); i-- > stride;)
      if (i / stride % n) codes[i] -= codes[i - stride];
  for (const std::uint32_t code : codes) {
    const std::uint32_t d = code & mask;
    const std::uint32_t folded = d <= mask / 2 ? 2 * d : 2 * (mask - d) + 1;
    all.push_back(std::uint16_t(folded << (16 - bits)));
  }
}

/// Bricks in codes as two elements: their heads, and the differences of their codes, those of the
/// narrowest first and channel by channel, so that the deflated bytes beside each other are alike.
std::vector<std::string> packed_codes(std::string_view bytes, int channels) {
  const std::span words(reinterpret_cast<const std::uint64_t*>(bytes.data()), bytes.size() / 8);
  std::vector<std::uint32_t> heads;
  std::array<std::vector<const std::uint64_t*>, 3> bricks;  // their rows, by width
  for (std::size_t i = 0; i < words.size();) {
    const auto wide = std::size_t(width_of_head(words[i]));
    for (const std::uint64_t head : words.subspan(i, std::size_t(channels)))
      heads.insert(heads.end(), {std::uint32_t(head), std::uint32_t(head >> 32)});
    bricks[wide].push_back(&words[i] + channels);
    i += std::size_t(channels * code_words) << wide;
  }
  std::vector<std::uint16_t> differences;
  for (int wide = 0; wide < 3; ++wide)
    for (int channel = 0; channel < channels; ++channel)
      for (const std::uint64_t* const first : bricks[std::size_t(wide)])
        add_differences(first + channel, channels, wide, differences);
  return {packed(heads), packed(differences)};
}

}  // namespace

std::vector<std::string> packed(const gl::WebTexture& texture) {
  if (texture.code_channels > 0)
    return packed_codes(texture.channels[0].bytes, texture.code_channels);
  std::vector<std::string> texts;
  for (const gl::WebNumbers& some : texture.channels) texts.push_back(packed(some.bytes, 4));
  return texts;
}

}  // namespace psivox
