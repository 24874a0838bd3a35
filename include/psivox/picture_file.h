#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "psivox/image.h"
#include "psivox/medium.h"
#include "psivox/scene.h"

namespace psivox {

/// The colours of a view's values.
struct ColorScale {
  std::string title;               ///< the scene's, or the grid's name
  double min = 0, max = 1;         ///< values of the first and the last colour
  std::vector<glm::dvec3> colors;  ///< the map's own, at equal distances of the scaled value
  ValueScale values{};             ///< its unit set
  std::vector<double> labels{};    ///< not empty: the values that have colours, each a band alike
};

/// The values that get a label: round ones, powers of 10 of a scale of logarithms, or at most 24 of
/// the labels.
std::vector<double> bar_values(const ColorScale& scale);
/// Where a value is on the bar: 0 at its lower end, 1 at its upper one.
double bar_place(const ColorScale& scale, double value);

/// Unset if no colour map, transfer function or maximum gives values a colour.
std::optional<ColorScale> color_scale(const View& view);

/// Draws the scale with numbers into that strip, on an opaque ground. Returns false if the picture
/// is too small for it. `display`: how the file will show values, so that text is white there.
bool draw_color_bar(Image& image, const ColorScale& scale, const Display& display);

/// A length of the world, as it is in the plane across the view through the subject's middle.
struct ScaleBar {
  double length = 1;  ///< 1, 2 or 5 times a power of 10 [world units]
  double width = 0;   ///< at most a quarter [picture widths]
};
ScaleBar scale_bar(const View& view);

/// Draws the bar with its length into the lower left corner, on an opaque ground. Returns false if
/// the picture is too small for it. `display`: as for draw_color_bar.
bool draw_scale_bar(Image& image, const ScaleBar& bar, const Display& display);

/// A line on the picture.
struct LegendLine {
  glm::dvec2 from{0}, to{0};          ///< [pixels from the top left]
  bool behind = false;                ///< behind the medium
  std::optional<glm::dvec3> color{};  ///< as the display shows it; unset: the ink of texts
};

/// A text that begins at a place and lies on one side of it.
struct LegendText {
  glm::dvec2 at{0};    ///< [pixels from the top left]
  glm::dvec2 away{0};  ///< unit vector
  std::string text;
};

/// What a picture's file shows beside the picture.
struct Legend {
  std::optional<ColorScale> colors;  ///< --color-bar
  std::optional<ScaleBar> lengths;   ///< --scale-bar
  std::vector<glm::vec3> behind{};   ///< --background environment: radiance by pixels
  std::vector<LegendLine> lines{};   ///< --box, --axes
  std::vector<LegendText> texts{};   ///< the same, and --title
};

/// Height of letters in a picture of that height [pixels].
inline double letter_size(int height) { return std::clamp(height / 28.0, 11.0, 60.0); }

/// Adds the lines and texts of a view's --box, --axes and --title.
void add_annotations(const View& view, Legend& legend);

/// Draws the lines behind the medium, before a background is added.
void draw_lines_behind(Image& image, const Legend& legend, const Display& display);
/// Draws the other lines and the texts. `ink`: their light on the display.
void draw_annotations(Image& image, const Legend& legend, double ink, const Display& display);

/// The legend that the view's scene asks for.
Legend legend_of(const View& view);

/// Numbers from min to max at round distances, about `count` of them, as the bar's labels.
std::vector<double> round_values(double min, double max, int count);

struct PictureFile {
  std::string path;
  WriteOptions format{};              ///< its display is the scene's
  std::vector<std::string> layers{};  ///< the picture's layers, as --aov names them
};

/// Whether a look's background is wanted: not where a picture may be composited as it is.
bool shows_background(const std::string& path, const WriteOptions& format = {});

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

/// Completes a picture as its scene says, with background and legend (legend_of its view), which is
/// drawn for a file of sRGB `codes` only. Settles what the scene leaves open of its display.
/// Returns notices for the user.
std::vector<std::string> complete_picture(Image& image, Scene& scene, const Legend& legend,
                                          bool codes);

/// Completes the picture and writes it with the scene in its metadata. Throws Error(output).
WrittenPicture write_picture(Image& image, Scene scene, const Legend& legend,
                             const std::string& renderer, const PictureFile& file);

/// Throws Error(memory) if a picture does not fit into the machine's memory, so that a size that
/// cannot succeed is refused before the volume is read.
///
/// `layers`: one number a pixel each; `code_bytes`: of a pixel as its file encodes it.
void check_picture_memory(int width, int height, int layers, int code_bytes);

/// A scene as a file holds it.
struct SceneFile {
  Scene scene;
  std::vector<std::string> layers{};  ///< that the picture was drawn with, named as in --aov
};

/// Reads a scene from JSON or from the metadata of a picture that psivox wrote. The files that it
/// names are looked for where they were relative to the scene's file, then under their own names,
/// which in a picture are absolute. Throws Error(input), Error(usage).
SceneFile read_scene_file(const std::string& path);

/// The files that a scene is drawn from: volumes, functions, depths, lights.
std::vector<std::string> files_of(Scene scene);

/// Metadata from which read_scene_file reads the scene again, wherever the picture and its inputs
/// are moved together.
void add_scene(const Scene& scene, const std::vector<std::string>& layers,
               const std::filesystem::path& picture, std::map<std::string, std::string>& metadata);

}  // namespace psivox
