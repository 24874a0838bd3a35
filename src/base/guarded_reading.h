#pragma once

#include <filesystem>
#include <string>

namespace psivox {

/// From now on every VdbFile that is opened is read in a process of its own: a damaged or hostile
/// file that makes OpenVDB crash, hang or ask for all memory is an Error(input), and a file that
/// takes the process over can neither open files nor start programs there.
///
/// To be called at the beginning of main(), before any thread starts: it forks a process that forks
/// the readers. That process ends with this one. Without this call, VdbFile reads in place, and
/// such a file can end the program. Throws Error(failure) if the system starts no process.
void start_guarded_reading();

/// For a process that may have threads already, such as an interpreter: it starts `server`, a
/// program that calls serve_guarded_reading(), in place of a fork. Any thread may call it, at any
/// time. Throws Error(failure).
void start_guarded_reading(const std::filesystem::path& server);

/// The main() of that program.
[[noreturn]] void serve_guarded_reading();

/// VdbFiles that are opened from now on are read in place, as `--trust` asks for.
void trust_files();

/// What guards reading here: `seccomp and resource limits`; `resource limits, without seccomp` if
/// the kernel lacks it; `nothing` if files are read in place, or `nothing: ` and why this psivox
/// always does so.
std::string reading_guard();

}  // namespace psivox
