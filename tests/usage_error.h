#pragma once

#include <gtest/gtest.h>

#include <string>

#include "psivox/error.h"

namespace psivox {

/// The message of the usage error that `action` throws, otherwise what went wrong.
template <typename Action>
std::string usage_error(Action action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    const std::string message = error.what();
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }
  return "no error";
}

}  // namespace psivox
