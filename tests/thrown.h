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

/// Whether a text has a part.
[[nodiscard]] inline testing::AssertionResult has(const std::string& text,
                                                  const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "'" << part << "' is not in '" << text << "'";
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
