// Pictures of other renderers in a study.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "base/text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "psivox/picture_file.h"
#include "study/study_pictures.h"

namespace psivox {
namespace {

/// A name becomes a file's, a cell of CSV and a line of a legend.
void check_name_and_time(const ForeignPicture& picture) {
  constexpr const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789";
  const std::string& name = picture.name;
  const bool plain = name.find_first_not_of(letters + std::string(" ._+-")) == name.npos;
  if (!plain || name.find_first_of(letters) != 0 || name.back() == ' ' || name == "psivox")
    throw Error(ExitCode::usage, in_quotes(name) +
                                     ": not a renderer's name; letters, digits, spaces and . _ + - "
                                     "make one, a letter or digit first, other than psivox");
  if (!std::isfinite(picture.time_ms) || picture.time_ms < 0)
    throw Error(ExitCode::usage, in_quotes(name) + ": its time is " + number_text(picture.time_ms) +
                                     "; give milliseconds above 0, or none");
}

bool is_opaque(const Image& image) {
  const auto rgba = image.rgba();
  for (std::size_t i = 3; i < rgba.size(); i += 4)
    if (rgba[i] != 1) return false;
  return true;
}

}  // namespace

std::string file_name(const ForeignPicture& picture) {
  std::string name = "foreign_" + picture.name;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

ForeignPicture foreign_picture(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == text.npos || equals + 1 == text.size())
    throw Error(ExitCode::usage, "--add " + in_quotes(text) + ": expected NAME=PICTURE[,TIME_MS]");
  ForeignPicture picture{std::string(text.substr(0, equals)), std::string(text.substr(equals + 1))};
  const std::size_t comma = picture.file.rfind(',');
  if (comma != std::string::npos &&
      read_number(std::string_view(picture.file).substr(comma + 1), picture.time_ms))
    picture.file.resize(comma);
  return picture;
}

std::vector<ForeignPicture> read_foreign_pictures(const std::string& path) {
  std::vector<ForeignPicture> pictures;
  try {
    const auto list = nlohmann::json::parse(read_text(path, "list of pictures"));
    if (!list.is_array()) throw Error(ExitCode::usage, "expected a list, [{\"name\": , ...}, ...]");
    for (const auto& item : list) {
      for (const auto& [key, value] : item.items())
        if (const std::vector<std::string> keys = {"name", "picture", "time_ms"};
            std::ranges::find(keys, key) == keys.end())
          throw Error(ExitCode::usage, "no key " + in_quotes(key) + suggestion(key, keys));
      const std::filesystem::path file = item.at("picture").get<std::string>();
      pictures.push_back({item.at("name").get<std::string>(),
                          (std::filesystem::path(path).parent_path() / file).string()});
      if (item.contains("time_ms") && !item["time_ms"].is_null())
        pictures.back().time_ms = item["time_ms"].get<double>();
    }
  } catch (const nlohmann::json::exception& error) {
    throw Error(ExitCode::usage, path + ": not a list of pictures in JSON: " + error.what());
  } catch (const Error& error) {
    if (error.code() != ExitCode::usage) throw;
    throw Error(ExitCode::usage, path + ": " + error.what());
  }
  return pictures;
}

void check_foreign(const StudyOptions& options, const Scene& scene) {
  std::vector<glm::ivec2> sizes = options.sweep.resolutions;
  if (sizes.empty()) sizes.push_back(scene.resolution);
  std::set<std::string> files;
  for (const ForeignPicture& foreign : options.foreign) {
    check_name_and_time(foreign);
    if (!files.insert(file_name(foreign)).second)
      throw Error(ExitCode::usage, "two pictures are named " + in_quotes(foreign.name));
    const Image image = read_image(foreign.file);
    std::string wanted;
    for (const glm::ivec2& size : sizes)
      wanted += formatted(wanted.empty() ? "%dx%d" : " or %dx%d", size.x, size.y);
    if (std::ranges::find(sizes, glm::ivec2(image.width, image.height)) == sizes.end())
      throw Error(ExitCode::input, in_quotes(foreign.file) +
                                       formatted(" has %dx%d", image.width, image.height) +
                                       " pixels; the study's pictures have " + wanted);
    const auto bad = std::ranges::count_if(image.rgba(), [](float v) { return !std::isfinite(v); });
    if (bad > 0)
      throw Error(ExitCode::input, in_quotes(foreign.file) + " has NaN or Inf in " +
                                       std::to_string(bad) + " values");
  }
}

ComparedPicture compare_foreign(const ForeignPicture& foreign, const Image& picture,
                                Image reference, const glm::dvec3& color,
                                const std::vector<glm::vec3>& behind) {
  ForeignPoint point{.picture = foreign, .resolution = {picture.width, picture.height}};
  point.opaque = is_opaque(picture) && !is_opaque(reference);
  if (point.opaque) add_background(reference, color, behind);
  point.error = picture_error(picture, reference);
  const Deviation& radiance = point.error.radiance;
  point.difference_scale = radiance.p99 > 0 ? radiance.p99 : radiance.max;
  return {point, difference_picture(picture, reference, point.difference_scale)};
}

}  // namespace psivox
