#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <thread>

namespace psivox::view {

/// One task at a time in a thread of its own: a picture that is being saved.
class SaveJob {
 public:
  ~SaveJob() {
    if (thread_.joinable()) thread_.join();
  }

  bool running() const { return thread_.joinable(); }

  /// `task` returns the error's message, or nothing. `on_done` is called from the thread.
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
  /// Once, when it has ended.
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
