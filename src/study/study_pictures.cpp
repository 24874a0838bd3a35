#include "study/study_pictures.h"

#include <algorithm>

#include "psivox/error.h"
#include "psivox/parameters.h"
#include "psivox/picture_file.h"
#include "psivox/stopwatch.h"
#include "study/report.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// The view of the scene that all variants share.
View shared_view(View view) {
  view.scene = studied_scene(view.scene);
  return view;
}

}  // namespace

StudyPictures::StudyPictures(View view, const StudyOptions& options)
    : options_(options),
      session_(shared_view(std::move(view))),
      scene_(session_.view().scene),
      gpu_(open_gpu({.device = scene_.device})),
      double_(open_double()),
      reference_(open_reference()) {}

void StudyPictures::stop_if_asked() const {
  if (options_.stop && options_.stop()) throw Error(ExitCode::interrupted, "interrupted");
}

Wish StudyPictures::wish_of(const Variant& variant) const {
  Wish wish;
  wish.scene = scene_of(variant, scene_);
  wish.progress = [this](Stage, double) { stop_if_asked(); };
  return wish;
}

Image StudyPictures::make_reference(const Variant& variant) {
  const fs::path path = options_.folder / (reference_name(variant) + ".exr");
  Wish wish = wish_of(variant);
  Scene own = scene_;
  own.resolution = wish.scene->resolution;
  wish.scene = own;
  wish.layers.error = true;
  const std::string scene = to_json(own);
  if (options_.resume && fs::exists(path) && read_metadata(path, "psivox:scene") == scene)
    return read_image(path);
  Image image = session_.draw(*reference_, wish).image;
  image.metadata["psivox:scene"] = scene;
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
        reference_bound_ = std::max(reference_bound_, double(bound));
  return image;
}

CostTrial StudyPictures::trial(const Variant& variant) {
  constexpr int part = 8;
  const auto seconds = [&](Marcher& marcher, const Wish& wish) {
    const Stopwatch watch;
    session_.draw(marcher, wish);
    return watch.ms() / 1e3;
  };
  const Wish whole = wish_of(variant);
  Wish small = whole;
  small.resolution = glm::max(whole.scene->resolution / part, 1);
  CostTrial trial;
  const double first = seconds(*gpu_, whole);
  trial.gpu = seconds(*gpu_, whole);
  trial.compile = std::max(first - trial.gpu, 0.0);
  if (options_.split) trial.march = part * part * seconds(*double_, small);
  trial.reference = part * part * seconds(*reference_, small);
  return trial;
}

Legend StudyPictures::legend(const glm::ivec2& resolution) const {
  View own = session_.view();
  own.scene.resolution = resolution;
  own.camera = make_camera(own.scene, *own.subject);
  return legend_of(own);
}

void StudyPictures::write_png(Image image, const Scene& scene, const fs::path& path) const {
  write_picture(image, scene, legend(scene.resolution), renderer(), {path.string()});
}

ForeignPoint StudyPictures::compare(const ForeignPicture& foreign) const {
  const Image picture = read_image(foreign.file);
  const auto same_size = [&](const auto& reference) {
    return reference.second.width == picture.width && reference.second.height == picture.height;
  };
  const Image& reference = std::ranges::find_if(references_, same_size)->second;
  Scene scene = scene_;
  scene.resolution = {picture.width, picture.height};
  const Legend behind = legend(scene.resolution);
  const auto [point, difference] = compare_foreign(
      foreign, picture, reference, scene.background.value_or(glm::dvec3(0)).color, behind.behind);
  const std::string file = file_name(foreign) + ".png";
  write_image(difference, options_.folder / differences_folder / file);
  Image shown = picture;
  write_picture(shown, scene, behind, shown_name(point),
                {(options_.folder / pictures_folder / file).string()});
  return point;
}

}  // namespace psivox
