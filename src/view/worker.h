#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace psivox::view {

/// A stage of work, and how much of it is done; 0: not known.
using WorkStage = std::pair<std::string, double>;

/// A thread that works for the window. Its mutex guards what both know.
class Worker {
 public:
  /// The work that takes longer than a picture; nullopt: there is none.
  std::optional<WorkStage> progress() const {
    const std::lock_guard lock(mutex_);
    return progress_;
  }

 protected:
  /// The thread calls `on_news`.
  explicit Worker(std::function<void()> on_news) : on_news_(std::move(on_news)) {}

  void start(std::function<void(std::stop_token)> run) { thread_ = std::jthread(std::move(run)); }
  /// Ends the thread; `change` ends what it works on.
  void stop(const std::function<void()>& change) {
    thread_.request_stop();
    post(change);
    thread_.join();
  }
  /// Changes what the thread is to do, and wakes it.
  void post(const std::function<void()>& change) {
    {
      const std::lock_guard lock(mutex_);
      change();
    }
    changed_.notify_all();
  }
  /// Changes what the window is to know, and has it ask.
  void tell(const std::function<void()>& change) {
    {
      const std::lock_guard lock(mutex_);
      change();
    }
    on_news_();
  }

  std::function<void()> on_news_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<WorkStage> progress_;

 private:
  std::jthread thread_;
};

}  // namespace psivox::view
