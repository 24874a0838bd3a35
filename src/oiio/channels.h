#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace psivox::image_io {

/// A layer to be read, and where its channels are among those of the file.
struct LayerSource {
  std::string name;
  std::vector<std::string> channels;
  std::vector<std::optional<std::size_t>> indices;  ///< none: the channel is 1 everywhere
};

/// Sorts a file's channels into layers, the inverse of exr_channel_name. First the picture, from
/// R G B or from the grey Y, alpha 1 if there is no A; then every other channel, those of one
/// prefix (`normal.X`, `normal.Y`) in one layer. Nothing if the file has no picture.
std::optional<std::vector<LayerSource>> layers_from_channels(const std::vector<std::string>& names);

}  // namespace psivox::image_io
