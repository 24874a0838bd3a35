#pragma once

#include <cstdint>
#include <filesystem>

namespace psivox {

/// Memory that this process could still take [bytes]; 0 if it is not known. The least of what the
/// machine has free or would give up at once, of what the limits of its control groups (v1 and v2)
/// leave, and of what the shell's limit of the address space leaves. Every choice that depends on
/// memory asks this function. `root`: where /proc and /sys are.
std::uint64_t available_memory(const std::filesystem::path& root = "/");

}  // namespace psivox
