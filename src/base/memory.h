#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>

namespace psivox {

/// Memory that this process could still take [bytes]; 0 if it is not known. The least of what the
/// machine has free or would give up at once, of what the limits of its control groups (v1 and v2)
/// leave, and of what the shell's limit of the address space leaves. Every choice that depends on
/// memory asks this function. `root`: where /proc and /sys are.
std::uint64_t available_memory(const std::filesystem::path& root = "/");

/// Throws Error(memory) if that many bytes are more than there are, or more than limit_claims()
/// allows. Who makes what a file asks for calls it first, so that a small file takes no memory that
/// it has not. `what` begins the message.
void claim_memory(double bytes, const std::string& what);

/// The limit of the scene that was opened last [bytes]; 0: none.
void limit_claims(std::uint64_t bytes);

/// Whether the system gave no thread, or no memory for one: std::thread and TBB tell it in words
/// alone.
bool lacks_threads(const std::exception& error);

/// Pages of the system's own, which it takes back at once when they are no longer held. Throws
/// std::bad_alloc.
std::shared_ptr<void> pages(std::size_t bytes);

/// Gives the whole pages of a part of them back that nobody reads any more.
void give_back(void* first, std::size_t bytes);

/// An array that begins where a page does, and has its pages for itself, so that another process or
/// a driver can take them.
template <typename T>
std::shared_ptr<T[]> page_array(std::size_t count) {
  const std::shared_ptr<void> all = pages(count * sizeof(T));
  return {all, static_cast<T*>(all.get())};
}

}  // namespace psivox
