#include "study/difference_picture.h"

#include <cmath>

#include "psivox/colormap.h"

namespace psivox {

Image difference_picture(const Image& a, const Image& b, double scale) {
  Image out;
  out.width = a.width;
  out.height = a.height;
  out.layers.push_back({"", {"R", "G", "B", "A"}, std::vector<float>(a.rgba().size(), 1.0f)});
  for (std::size_t i = 0; i < a.rgba().size(); i += 4) {
    double largest = 0;
    for (std::size_t c = i; c < i + 3; ++c) {
      const double d = double(a.rgba()[c]) - double(b.rgba()[c]);
      if (std::abs(d) > std::abs(largest)) largest = d;
    }
    const glm::dvec3 color =
        colormap_color(Colormap::coolwarm, scale > 0 ? 0.5 + 0.5 * largest / scale : 0.5);
    for (int c = 0; c < 3; ++c) out.rgba()[i + std::size_t(c)] = float(color[c]);
  }
  return out;
}

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
