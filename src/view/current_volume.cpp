#include "view/volume.h"

namespace psivox::view {
namespace {

/// Thrown to end the preparation of a volume that is no longer wished.
struct Superseded {};

}  // namespace

CurrentVolume::CurrentVolume(std::function<void()> on_news)
    : on_news_(std::move(on_news)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

CurrentVolume::~CurrentVolume() {
  thread_.request_stop();
  post([&] { ++wishes_; });
  thread_.join();
}

void CurrentVolume::post(const std::function<void()>& change) {
  {
    const std::lock_guard lock(mutex_);
    change();
  }
  changed_.notify_all();
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
    wish_ = Wish{scene, samples, generation_, key};
    idle_wish_.reset();
    ++wishes_;
    news_ = {};  // of a wish that this one replaces
  });
  awaited_key_ = key;
  return false;
}

void CurrentVolume::prefetch(const Scene& scene, const std::vector<std::string>& samples) {
  post([&] { idle_wish_ = Wish{scene, samples, generation_, volume_key(scene, generation_)}; });
}

void CurrentVolume::reload() {
  ++generation_;
  retry();
}

std::optional<WorkStage> CurrentVolume::progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
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
    bool wanted = true;
    std::uint64_t number = 0;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [&] { return wish_ || idle_wish_; });
      if (stop.stop_requested()) return;  // even if there is a wish
      wanted = wish_.has_value();
      std::optional<Wish>& next = wanted ? wish_ : idle_wish_;
      wish = std::move(*next);
      next.reset();
      number = wishes_;
    }
    prepare(wish, wanted, number);
    on_news_();
  }
}

void CurrentVolume::prepare(const Wish& wish, bool wanted, std::uint64_t number) {
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
          [&](const std::shared_ptr<const Subject>& subject) {
            if (!wanted) return;
            {
              const std::lock_guard lock(mutex_);
              if (wishes_ != number) throw Superseded();
              news_.subject = subject;
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
  if (wishes_ != number || !(volume || error)) return;
  news_.volume = volume;
  news_.error = error;
}

}  // namespace psivox::view
