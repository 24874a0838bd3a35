#pragma once

#include <sys/types.h>

#include "socket.h"

namespace psivox::vdb {

/// Whether start_guarded_reading() was called, and trust_files() was not.
bool reads_guarded();

/// The ends of a new reader process that belong to this one.
struct ReaderEnds {
  Descriptor connection;  ///< messages to and from the reader
  /// From the fork server: the reader's id as a pid_t, once it runs, and its status as waitpid has
  /// it in an int, once it has ended. Closing it ends the reader.
  Descriptor life;
};

/// Starts a reader. May be called from several threads. Throws Error(failure).
ReaderEnds start_reader();

}  // namespace psivox::vdb
