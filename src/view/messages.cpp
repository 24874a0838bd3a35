#include "view/messages.h"

#include <cstdio>
#include <new>

namespace psivox::view {
namespace {

constexpr auto shown_for = std::chrono::seconds(8);

}  // namespace

void Messages::error(const std::string& text) {
  say(text);
  is_error_ = true;
  ++error_count_;
  std::fprintf(stderr, "psivox: %s\n", text.c_str());
}

void Messages::say(const std::string& text) {
  text_ = text;
  is_error_ = false;
  since_ = Clock::now();
  on_news_();
}

void Messages::attempt(const std::function<void()>& action) {
  try {
    action();
  } catch (...) {
    error(message_of(std::current_exception()));
  }
}

const std::string& Messages::shown() const {
  return Clock::now() - since_ > shown_for ? none_ : text_;
}

std::string message_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    return "out of memory; try --texel float16";
  } catch (const std::exception& e) {
    return e.what();
  }
}

}  // namespace psivox::view
