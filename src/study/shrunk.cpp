#include "study/shrunk.h"

namespace psivox {

Image shrunk(const Image& image, int width) {
  const int block = (image.width + width - 1) / width;
  Image out;
  out.width = (image.width + block - 1) / block;
  out.height = (image.height + block - 1) / block;
  out.layers.push_back({"",
                        {"R", "G", "B", "A"},
                        std::vector<float>(std::size_t(out.width) * std::size_t(out.height) * 4)});
  std::vector<float> counts(out.layers[0].values.size());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 4; ++c) {
        const auto to = std::size_t((y / block * out.width + x / block) * 4 + c);
        out.rgba()[to] += image.rgba()[std::size_t(y * image.width + x) * 4 + std::size_t(c)];
        counts[to] += 1;
      }
  for (std::size_t i = 0; i < counts.size(); ++i) out.rgba()[i] /= counts[i];
  return out;
}

}  // namespace psivox
