#pragma once

#include <filesystem>

#include "psivox/error.h"
#include "psivox/text.h"

namespace psivox {

/// Makes the folder and its parents. Throws Error(output).
inline void make_folder(const std::filesystem::path& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure || !std::filesystem::is_directory(folder))
    throw Error(ExitCode::output, "cannot make the folder " + in_quotes(folder.string()) +
                                      (failure ? ": " + failure.message() : ""));
}

}  // namespace psivox
