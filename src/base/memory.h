#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>

namespace psivox {

/// Memory that this process could still take [bytes]; 0 if it is not known. The least of what the
/// machine has free or would give up at once, of what the limits of its control groups (v1 and v2)
/// leave, and of what the shell's limit of the address space leaves. Every choice that depends on
/// memory asks this function. `root`: where /proc and /sys are.
std::uint64_t available_memory(const std::filesystem::path& root = "/");

/// Whether the system gave no thread, or no memory for one: std::thread and TBB tell it in words
/// alone.
bool lacks_threads(const std::exception& error);

/// Blocks up to this size come from the heap, and go back to it [bytes]: glibc's limit.
constexpr std::size_t most_kept_block = std::size_t{1} << 25;

/// From now on this process keeps what it frees for its next allocations. For programs, early: what
/// runs inside another program leaves the allocator to that one.
void keep_freed_memory();

/// An array that begins where a page of any system does, and has its pages for itself, so that
/// another process or a driver can take them. Its values are not initialised.
template <typename T>
std::shared_ptr<T[]> page_array(std::size_t count) {
  constexpr std::size_t page = std::size_t{1} << 16;  // the largest of Linux
  const std::size_t bytes = (count * sizeof(T) + page - 1) / page * page;
  return {static_cast<T*>(::operator new (bytes, std::align_val_t{page})),
          [](T* first) { ::operator delete (first, std::align_val_t{page}); }};
}

/// Asks the kernel to give an array large pages when it is first written to.
void ask_for_large_pages(void* first, std::size_t bytes);

/// While it lives, the next 62 MiB of the calling thread's heap are in large pages, if the kernel
/// has them: a small picture takes a third of the page faults. After keep_freed_memory(). A fork
/// takes large pages apart where it writes, so that each process has its own.
class LargePages {
 public:
  LargePages();

 private:
  std::unique_ptr<void, void (*)(void*)> before_;  ///< up to the first large page, never touched
};

/// Makes the process give freed memory back to the system at once, which costs some time. glibc
/// otherwise keeps blocks of up to 32 MiB, so that parts of a volume would add up.
void give_back_freed_memory();

/// Whether an array's values are to be discarded before it is freed: where keep_freed_memory() was
/// called, what follows takes the memory of a smaller one, and finds its pages there.
constexpr bool is_worth_discarding(std::size_t bytes) { return bytes > most_kept_block; }

/// Puts empty pages in place of an array's whole pages, where it can. Its values are lost. The
/// system gets the memory; if it is shared, once no mapping of it is left.
void discard_values(void* first, std::size_t bytes);

}  // namespace psivox
