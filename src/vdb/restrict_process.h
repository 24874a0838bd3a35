#pragma once

#include <cstdint>

namespace psivox::vdb {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitised = true;  ///< slow, with terabytes of addresses, and it opens files
#else
inline constexpr bool sanitised = false;
#endif

/// Whether the kernel can restrict a process's system calls.
bool has_seccomp();

/// Limits this process, for good: it can have `memory` bytes of its own and write as many to shared
/// memory (0: any number), leaves no core file, and can neither open files nor start programs, nor
/// reach others. To be called before it starts threads.
void restrict_process(std::uint64_t memory);

}  // namespace psivox::vdb
