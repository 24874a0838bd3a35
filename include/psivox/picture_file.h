#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "psivox/image.h"
#include "psivox/legend.h"
#include "psivox/scene.h"

namespace psivox {

/// A file for a picture.
struct PictureFile {
  std::string path;
  WriteOptions format{};              ///< its display is the scene's
  std::vector<std::string> layers{};  ///< the picture's layers, as --aov names them
};

/// Whether a look's background is wanted: not where a picture may be composited as it is.
bool shows_background(const std::string& path);

/// The metadata of a picture of that scene, except for the renderer's name.
std::map<std::string, std::string> picture_metadata(const PictureFile& file, const Scene& scene);

struct WrittenPicture {
  std::vector<std::string> notices;  ///< for the user
  std::size_t clipped = 0;           ///< pixels brighter than white
  std::uintmax_t bytes = 0;          ///< of the file
  double write_ms = 0;
};

/// The display that sRGB codes of the scene's picture are for; 0 for an exposure left to `auto`.
Display display_of(const Scene& scene);

/// Completes a scene that uses OpenColorIO: the config by $OCIO, display, view and colour space by
/// the config. Throws Error(usage) if there is no config, Error(input) if it cannot be read or
/// lacks what the scene names.
void resolve_ocio(Scene& scene);

/// Composites the picture with its scene's background and the legend's environment. The picture
/// becomes opaque.
void add_background(Image& image, const glm::dvec3& color, const std::vector<glm::vec3>& behind);

/// Completes the picture as its scene says, with background and legend (legend_of its view), and
/// writes it with the scene in its metadata. Throws Error(output).
WrittenPicture write_picture(Image& image, Scene scene, const Legend& legend,
                             const std::string& renderer, const PictureFile& file);

/// Throws Error(memory) if a picture does not fit into the machine's memory, so that a size that
/// cannot succeed is refused before the volume is read.
///
/// `layers`: one number a pixel each; `code_bytes`: of a pixel as its file encodes it.
void check_picture_memory(int width, int height, int layers, int code_bytes);

}  // namespace psivox
