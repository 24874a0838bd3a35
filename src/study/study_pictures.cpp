#include "study/study_pictures.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "base/input_file.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "psivox/page.h"
#include "psivox/parameters.h"
#include "scene/json_problem.h"
#include "study/page.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// The view of the scene that all variants share.
View shared_view(View view) {
  view.scene = studied_scene(view.scene);
  return view;
}

constexpr double worth_a_line = 60, short_study = 300;  ///< [s]

/// "40 seconds", "7 minutes", "1.5 hours".
std::string duration_text(double seconds) {
  if (seconds < 90) return decimals(seconds, 0) + " seconds";
  if (seconds < 90 * 60) return decimals(seconds / 60, 0) + " minutes";
  return decimals(seconds / 3600, 1) + " hours";
}

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

/// One of the list in the file at `path`.
ForeignPicture foreign_picture(const nlohmann::json& item, const std::filesystem::path& path) {
  const auto fail = [](const std::string& what) { throw Error(ExitCode::usage, what); };
  if (!item.is_object() || !item.contains("name") || !item.contains("picture"))
    fail("each picture is an object with name and picture, not " + in_quotes(item.dump()));
  check_keys(item, {"name", "picture", "time_ms"}, "a picture", ExitCode::usage);
  for (const char* key : {"name", "picture"})
    if (!item[key].is_string())
      fail(std::string(key) + ": expected a text, not " + item[key].dump());
  const nlohmann::json time = item.value("time_ms", nlohmann::json());
  if (!time.is_number() && !time.is_null()) fail("time_ms: expected a number, not " + time.dump());
  const std::filesystem::path file = path.parent_path() / item["picture"].get<std::string>();
  return {item["name"], file.string(), time.is_null() ? 0 : time.get<double>()};
}

}  // namespace

StudyPictures::StudyPictures(View view, const StudyOptions& options)
    : options_(options),
      session(shared_view(std::move(view))),
      scene(session.view().scene),
      gpu(open_gpu({.device = scene.device})),
      by_double(open_double()),
      by_reference(open_reference()) {}

Wish StudyPictures::wish_of(const Variant& variant) const {
  Wish wish;
  wish.scene = scene_of(variant, scene);
  wish.progress = [&stop = options_.stop](Stage, double) {
    if (stop && stop()) throw Error(ExitCode::interrupted, "interrupted");
  };
  return wish;
}

/// As an earlier run of the study left it, or drawn. The bound always comes from the layer as
/// saved, so both cases give the same bound.
Image StudyPictures::make_reference(const Variant& variant) {
  const fs::path path = options_.folder / (reference_name(variant) + ".exr");
  Wish wish = wish_of(variant);
  Scene own = scene;
  own.resolution = wish.scene->resolution;
  wish.scene = own;
  wish.layers.error = true;
  const std::string text = to_json(own);
  if (options_.resume && fs::exists(path)) {
    const EarlierOutput drawn;
    if (read_metadata(path, "psivox:scene") == text)
      if (Image kept = read_image(path); glm::ivec2(kept.width, kept.height) == own.resolution)
        return kept;
  }
  Image image = session.draw(*by_reference, wish).image;
  image.metadata["psivox:scene"] = text;
  write_image(image, path);
  return image;
}

const Image& StudyPictures::reference(const Variant& variant) {
  const std::string name = reference_name(variant);
  if (const auto found = references_.find(name); found != references_.end()) return found->second;
  const Image& image = references_[name] = make_reference(variant);
  write_png(image, wish_of(variant).scene.value(), options_.folder / (name + ".png"));
  for (const Layer& layer : image.layers)
    if (layer.name == "error")
      for (const float bound : layer.values)
        reference_bound = std::max(reference_bound, double(bound));
  return image;
}

CostTrial StudyPictures::trial(const Variant& variant) {
  constexpr int part = 8;
  const auto seconds = [&](Marcher& marcher, const Wish& wish) {
    const Stopwatch watch;
    session.draw(marcher, wish);
    return watch.ms() / 1e3;
  };
  const Wish whole = wish_of(variant);
  Wish small = whole;
  small.resolution = glm::max(whole.scene->resolution / part, 1);
  CostTrial trial;
  const double first = seconds(*gpu, whole);
  trial.gpu = seconds(*gpu, whole);
  trial.compile = std::max(first - trial.gpu, 0.0);
  if (options_.split) trial.march = part * part * seconds(*by_double, small);
  trial.reference = part * part * seconds(*by_reference, small);
  return trial;
}

Legend StudyPictures::legend(const glm::ivec2& resolution) const {
  View own = session.view();
  own.scene.resolution = resolution;
  own.camera = make_camera(own.scene, *own.subject);
  return legend_of(own);
}

void StudyPictures::write_png(Image image, const Scene& own, const fs::path& path) const {
  write_picture(image, own, legend(own.resolution), description(*gpu), {path.string()});
}

void StudyPictures::write_turning_page() {
  Wish wish = wish_of({});
  wish.scene = with_default_tolerance(scene);
  wish.fewest_bytes = true;
  if (!page_obstacle(*wish.scene).empty()) return;
  const Drawn drawn = session.draw(*gpu, wish);
  try {
    const std::string page = page_text(session, drawn, {.limit_mb = 2});
    write_text((options_.folder / turning_name).string(), page);
  } catch (const Error& error) {
    if (error.code() != ExitCode::usage && error.code() != ExitCode::memory) throw;
  }
}

ForeignPoint StudyPictures::compare(const ForeignPicture& foreign) const {
  Image picture = read_image(foreign.file);
  const auto same_size = [&](const auto& reference) {
    return reference.second.width == picture.width && reference.second.height == picture.height;
  };
  const Image& reference = std::ranges::find_if(references_, same_size)->second;
  Scene own = scene;
  own.resolution = {picture.width, picture.height};
  const Legend around = legend(own.resolution);
  const auto [point, difference] = compare_foreign(
      foreign, picture, reference, own.background.value_or(glm::dvec3(0)).color, around.behind);
  const std::string file = file_name(foreign) + ".png";
  write_image(difference, options_.folder / differences_folder / file);
  write_picture(picture, own, around, point.picture.name + " (foreign)",
                {(options_.folder / pictures_folder / file).string()});
  return point;
}

double StudyCost::pixels(const Variant& v) const {
  const glm::dvec2 own(scene_of(v, scene_).resolution), all(scene_.resolution);
  return own.x * own.y / (all.x * all.y);
}

double StudyCost::picture(const Variant& v) const {
  const Method& method = v.method;
  // as processor times of all rules go by step and segments: a fog of one emission, llvmpipe
  const double work = v.tolerance                            ? 3
                      : method.sampling == Sampling::uniform ? 0.5 / method.step
                      : method.segments == 0                 ? 0.6
                                                             : 0.2 + 0.4 * method.segments;
  return unit_ * (0.1 + work * pixels(v));
}

double StudyCost::references() const {
  double sum = 0;
  std::set<std::string> names;
  for (const Variant& v : plan_.variants)
    if (names.insert(reference_name(v)).second) sum += reference_ * pixels(v);
  return sum;
}

double StudyCost::measuring(std::size_t i) const {
  const Variant& v = plan_.variants[i];
  const Variant& last = plan_.variants[i > 0 ? i - 1 : 0];
  const bool new_program = i == 0 || last.method.integrator != v.method.integrator ||
                           last.method.sampling != v.method.sampling || last.filter != v.filter ||
                           v.tolerance;
  return picture(v) * (2 + (options_.split ? march_ : 0)) + (new_program ? compile_ : 0);
}

double StudyCost::left(const std::vector<std::optional<StudyPoint>>& points) const {
  double sum = references();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i] || (options_.split && !points[i]->arithmetic)) sum += measuring(i);
    const auto timed = points[i] ? int(points[i]->times.size()) : 0;
    sum += std::max(options_.repeats - timed, 0) * picture(plan_.variants[i]);
  }
  return sum;
}

std::string StudyCost::forecast(const Variant& tried, const CostTrial& trial) {
  unit_ *= trial.gpu / picture(tried);
  compile_ = 2 * trial.compile;
  march_ = trial.march / trial.gpu;
  reference_ = trial.reference / pixels(tried);
  const double all = left(std::vector<std::optional<StudyPoint>>(plan_.variants.size()));
  if (all < worth_a_line) return "";
  double marching = 0, fixed = 0;  // the marches in double, and what the size does not change
  for (std::size_t i = 0; i < plan_.variants.size(); ++i) {
    const double gpu = picture(plan_.variants[i]), march = march_ * gpu;
    marching += march;
    fixed += measuring(i) - 2 * gpu - march;
  }
  int part = 2;
  const auto smaller = [&] { return fixed + (all - fixed) / (part * part); };
  while (part < 8 && smaller() > short_study) ++part;
  std::string text = "the study takes about " + duration_text(all) + ", by a trial; for less: ";
  if (options_.sweep.resolutions.empty())
    text +=
        formatted("--resolution %dx%d (", scene_.resolution.x / part, scene_.resolution.y / part) +
        duration_text(smaller()) + "), ";
  if (options_.split) text += "--no-split (" + duration_text(all - marching) + "), ";
  return text + "fewer --integrators or --steps";
}

std::string file_name(const ForeignPicture& picture) {
  return file_name("foreign_" + picture.name);
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
  const std::string text = read_text(path, "list of pictures");
  std::vector<ForeignPicture> pictures;
  try {
    const auto list = parsed_json(text, "a list of pictures", ExitCode::usage);
    if (!list.is_array()) throw Error(ExitCode::usage, "expected a list, [{\"name\": , ...}, ...]");
    for (const auto& item : list) pictures.push_back(foreign_picture(item, path));
  } catch (const Error& error) {
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
    if (!std::ranges::count(sizes, glm::ivec2(image.width, image.height)))
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
  point.difference_scale = point.error.full_color();
  return {point, difference_picture(picture, reference, point.difference_scale)};
}

}  // namespace psivox
