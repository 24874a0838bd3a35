#include "view/volume_loader.h"

#include <utility>

namespace psivox::view {
namespace {

/// Thrown to end the preparation of a volume that is no longer wished.
struct Superseded {};

}  // namespace

VolumeLoader::VolumeLoader(std::function<void()> on_news)
    : on_news_(std::move(on_news)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

VolumeLoader::~VolumeLoader() {
  thread_.request_stop();
  {
    const std::lock_guard lock(mutex_);
    ++wishes_;
  }
  changed_.notify_all();
  thread_.join();
}

void VolumeLoader::load(const Scene& scene, const std::vector<std::string>& samples,
                        int generation) {
  {
    const std::lock_guard lock(mutex_);
    wish_ = Wish{scene, samples, generation, volume_key(scene, generation)};
    idle_wish_.reset();
    ++wishes_;
  }
  changed_.notify_all();
}

void VolumeLoader::prefetch(const Scene& scene, const std::vector<std::string>& samples,
                            int generation) {
  {
    const std::lock_guard lock(mutex_);
    idle_wish_ = Wish{scene, samples, generation, volume_key(scene, generation)};
  }
  changed_.notify_all();
}

VolumeLoader::News VolumeLoader::news() {
  const std::lock_guard lock(mutex_);
  return std::exchange(news_, {});
}

std::optional<std::pair<std::string, double>> VolumeLoader::progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
}

void VolumeLoader::run(const std::stop_token& stop) {
  while (true) {
    Wish wish;
    bool wanted = true;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [&] { return wish_ || idle_wish_; })) return;
      wanted = wish_.has_value();
      wish = *(wanted ? wish_ : idle_wish_);
      (wanted ? wish_ : idle_wish_).reset();
    }
    prepare(wish, wanted);
    on_news_();
  }
}

void VolumeLoader::prepare(const Wish& wish, bool wanted) {
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    number = wishes_;
  }
  std::shared_ptr<Volume> volume =
      prefetched_ && prefetched_->key == wish.key ? prefetched_ : nullptr;
  std::exception_ptr error;
  try {
    if (!volume)
      volume = prepare_volume(
          wish.scene, wish.samples, wish.generation, last_,
          [&](const std::string& stage, double fraction) {
            const std::lock_guard lock(mutex_);
            if (wishes_ != number) throw Superseded();
            if (wanted) progress_ = {stage, fraction};
          },
          [&](const Subject& box) {
            if (!wanted) return;
            {
              const std::lock_guard lock(mutex_);
              news_.box = box;
            }
            on_news_();
          });
  } catch (const Superseded&) {
  } catch (...) {
    error = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  progress_.reset();
  if (!wanted) {
    if (volume) prefetched_ = volume;
    return;
  }
  if (volume == prefetched_) prefetched_.reset();
  if (volume) last_ = volume;
  if (volume) news_.volume = volume;
  if (error) news_.error = error;
  if (volume || error) news_.key = wish.key;
}

}  // namespace psivox::view
