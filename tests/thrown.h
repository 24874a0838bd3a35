#pragma once

#include <gtest/gtest.h>

#include <string>

#include "psivox/error.h"

namespace psivox {

/// The message, one line, of the Error that `action` throws, which must have this code. "no error"
/// if it throws none.
template <typename Action>
[[nodiscard]] std::string error_of(ExitCode code, Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.code(), code) << message;
    EXPECT_EQ(message.find_first_of("\r\n"), std::string::npos) << message;
    return message;
  }
  return "no error";
}

template <typename Action>
[[nodiscard]] std::string usage_error(Action&& action) {
  return error_of(ExitCode::usage, action);
}

template <typename Action>
[[nodiscard]] std::string input_error(Action&& action) {
  return error_of(ExitCode::input, action);
}

}  // namespace psivox
