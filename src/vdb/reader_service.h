#pragma once

#include <functional>
#include <string>

#include "socket.h"

namespace psivox::vdb {

/// Answers the messages of a GuardedReader until the connection ends; the process then ends, too.
/// The first message opens the file; from then on the process is restricted.
[[noreturn]] void serve_reader(int connection);

/// For tests: called with the file's path, the message and the connection before each answer, in
/// the reader's process. To be set before start_guarded_reading().
extern std::function<void(const std::string& path, const Message& message, int connection)>
    before_answer;

}  // namespace psivox::vdb
