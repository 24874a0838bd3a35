#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <thread>

namespace psivox::view {

/// Saves a picture in a thread of its own, one at a time.
class SaveJob {
 public:
  ~SaveJob() {
    if (thread_.joinable()) thread_.join();
  }

  bool running() const { return thread_.joinable(); }

  /// `task` returns an error's message, or an empty text. The thread calls `on_done`.
  void start(const std::string& what, const std::function<std::string()>& task,
             const std::function<void()>& on_done) {
    what_ = what;
    done_ = false;
    thread_ = std::thread([this, task, on_done] {
      error_ = task();
      done_ = true;
      on_done();
    });
  }

  struct Outcome {
    std::string what, error;
  };
  /// Returns the outcome once, after the task has ended.
  std::optional<Outcome> outcome() {
    if (!running() || !done_) return std::nullopt;
    thread_.join();
    return Outcome{what_, error_};
  }

  const std::string& what() const { return what_; }

 private:
  std::thread thread_;
  std::string what_, error_;
  std::atomic<bool> done_{false};
};

}  // namespace psivox::view
