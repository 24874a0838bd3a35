#include "marchers.h"

#include <algorithm>
#include <atomic>

#include "psivox/error.h"

namespace psivox::python {

namespace {
constexpr std::size_t most_idle = 2;
}

Marchers& marchers() {
  static auto* const kept = new Marchers;
  return *kept;
}

std::shared_ptr<Marcher> Marchers::take(RendererKind renderer, int device) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(idle_.begin(), idle_.end(), [&](const Idle& idle) {
      return idle.renderer == renderer && idle.device == device;
    });
    if (found != idle_.end()) {
      std::shared_ptr<Marcher> marcher = std::move(found->marcher);
      idle_.erase(found);
      return marcher;
    }
  }
  Scene scene;
  scene.renderer = renderer;
  scene.device = device;
  return open_marcher(scene);
}

void Marchers::give_back(RendererKind renderer, int device, std::shared_ptr<Marcher> marcher) {
  const std::lock_guard lock(mutex_);
  if (idle_.size() < most_idle) idle_.push_back({renderer, device, std::move(marcher)});
}

void Marchers::close() {
  const std::lock_guard lock(mutex_);
  idle_.clear();
}

Marcher& Lease::get(const Scene& scene) {
  if (marcher_ && (renderer_ != scene.renderer || device_ != scene.device)) end();
  if (!marcher_) {
    renderer_ = scene.renderer;
    device_ = scene.device;
    marcher_ = marchers().take(renderer_, device_);
  }
  return *marcher_;
}

void Lease::end(bool large) {
  if (marcher_ && !large) marchers().give_back(renderer_, device_, std::move(marcher_));
  marcher_.reset();
}

void check_process() {
  static std::atomic<pid_t> first = 0;
  pid_t none = 0;
  const pid_t own = getpid();
  if (!first.compare_exchange_strong(none, own) && none != own)
    throw Error(ExitCode::failure,
                "this process was forked from one that has used psivox; start it with "
                "multiprocessing.get_context('spawn')");
}

}  // namespace psivox::python
