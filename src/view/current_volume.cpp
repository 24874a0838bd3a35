#include "view/volume.h"

namespace psivox::view {
namespace {

/// Thrown to end the preparation of a volume that is no longer wished.
struct Superseded {};

}  // namespace

CurrentVolume::CurrentVolume(std::function<void()> on_news) : Worker(std::move(on_news)) {
  start([this](const std::stop_token& stop) { run(stop); });
}

CurrentVolume::~CurrentVolume() {
  stop([&] { ++wishes_; });
}

bool CurrentVolume::wish(const Scene& scene, const std::vector<std::string>& samples) {
  const std::string key = volume_key(scene, generation_);
  const bool at_hand = volume_ && volume_->key == key;
  if (at_hand && std::exchange(awaited_key_, {}))
    post([&] {
      wish_.reset();
      ++wishes_;  // ends the work on it
      news_ = {};
    });
  if (at_hand || key == refused_key_ || key == awaited_key_) return at_hand;
  post([&] {
    wish_ = Wish{scene, samples, generation_, key, true, ++wishes_};
    idle_wish_.reset();
    news_ = {};  // of a wish that this one replaces
  });
  awaited_key_ = key;
  return false;
}

void CurrentVolume::prefetch(const Scene& scene, const std::vector<std::string>& samples) {
  const std::string key = volume_key(scene, generation_);
  post([&] { idle_wish_ = Wish{scene, samples, generation_, key, false, wishes_}; });
}

void CurrentVolume::reload() {
  ++generation_;
  retry();
}

CurrentVolume::News CurrentVolume::take_news() {
  News news;
  {
    const std::lock_guard lock(mutex_);
    news = std::exchange(news_, {});
  }
  if (news.subject && !volume_) first_subject_ = news.subject;
  if (!news.volume && !news.error) return news;
  const std::string key = *std::exchange(awaited_key_, {});
  first_subject_.reset();
  if (news.error)
    refused_key_ = key;
  else
    volume_ = news.volume;
  return news;
}

void CurrentVolume::run(const std::stop_token& stop) {
  while (true) {
    Wish wish;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [&] { return wish_ || idle_wish_; });
      if (stop.stop_requested()) return;  // even if there is a wish
      wish = *std::exchange(wish_ ? wish_ : idle_wish_, {});
    }
    prepare(wish);
    on_news_();
  }
}

void CurrentVolume::prepare(const Wish& wish) {
  const auto check_current = [&] {
    if (wishes_ != wish.number) throw Superseded();
  };
  std::shared_ptr<Volume> volume =
      prefetched_ && prefetched_->key == wish.key ? prefetched_ : nullptr;
  std::exception_ptr error;
  try {
    if (!volume)
      volume = prepare_volume(
          wish.scene, wish.samples, wish.generation, last_,
          [&](const std::string& stage, double fraction) {
            const std::lock_guard lock(mutex_);
            check_current();
            if (wish.wanted) progress_ = {stage, fraction};
          },
          [&](const std::shared_ptr<const Subject>& subject) {
            if (!wish.wanted) return;
            tell([&] {
              check_current();
              news_.subject = subject;
            });
          });
  } catch (const Superseded&) {
  } catch (...) {
    error = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  progress_.reset();
  if (!wish.wanted) {
    if (volume) prefetched_ = volume;
    return;
  }
  if (volume == prefetched_) prefetched_.reset();
  if (volume) last_ = volume;
  if (wishes_ != wish.number) return;
  news_.volume = volume;
  news_.error = error;
}

}  // namespace psivox::view
