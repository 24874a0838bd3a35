#include "view/current_volume.h"

namespace psivox::view {

bool CurrentVolume::wish(const Scene& scene, const std::vector<std::string>& samples) {
  const std::string key = volume_key(scene, generation_);
  const bool at_hand = volume_ && volume_->key == key;
  if (at_hand) awaited_key_.reset();
  if (!at_hand && key != refused_key_ && key != awaited_key_) {
    loader_.load(scene, samples, generation_);
    awaited_key_ = key;
  }
  return at_hand;
}

void CurrentVolume::reload() {
  ++generation_;
  retry();
}

CurrentVolume::News CurrentVolume::take_news() {
  VolumeLoader::News loaded = loader_.news();
  News news;
  if (loaded.box && !volume_) {
    box_ = loaded.box;
    news.box_known = true;
  }
  if (!awaited_key_ || loaded.key != *awaited_key_) return news;
  awaited_key_.reset();
  news.error = loaded.error;
  if (loaded.error) {
    refused_key_ = loaded.key;
    return news;
  }
  news.first = !volume_;
  volume_ = std::move(loaded.volume);
  box_.reset();
  news.box_known = false;
  news.arrived = true;
  return news;
}

}  // namespace psivox::view
