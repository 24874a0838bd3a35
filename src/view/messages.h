#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace psivox::view {

/// The newest error or message to the user, which the window shows for some seconds.
class Messages {
 public:
  using Clock = std::chrono::steady_clock;

  /// `on_news` is called with each error and message.
  explicit Messages(std::function<void()> on_news) : on_news_(std::move(on_news)) {}

  /// Prints to stderr, too.
  void error(const std::string& text);
  void say(const std::string& text);
  /// Runs `action`; an exception becomes an error.
  void attempt(const std::function<void()>& action);

  /// Empty if a message followed it.
  const std::string& last_error() const { return is_error_ ? text_ : none_; }
  int error_count() const { return error_count_; }
  bool is_error() const { return is_error_; }
  /// The text to show now; may be empty.
  const std::string& shown() const;

 private:
  std::function<void()> on_news_;
  std::string text_, none_;
  bool is_error_ = false;
  int error_count_ = 0;
  Clock::time_point since_{};
};

/// The text of an exception, for a person.
std::string message_of(const std::exception_ptr& error);

}  // namespace psivox::view
