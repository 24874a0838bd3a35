#include "base/memory.h"

#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <new>
#include <string>
#include <string_view>

#include "base/text.h"
#include "psivox/error.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t unknown = std::numeric_limits<std::uint64_t>::max();

/// The number after a name, in a file of names and numbers.
std::uint64_t number_after(const fs::path& path, std::string_view wanted, std::uint64_t otherwise) {
  std::ifstream file(path);
  std::string name;
  std::uint64_t number = 0;
  while (file >> name >> number) {
    if (name == wanted) return number;
    file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return otherwise;
}

/// Names of the files of control groups, version 2 or 1, and of the cache of files, which is given
/// up when memory is asked for.
struct GroupFiles {
  const char *limit, *usage, *inactive, *active;
};
constexpr GroupFiles version_2{"memory.max", "memory.current", "inactive_file", "active_file"};
constexpr GroupFiles version_1{"memory.limit_in_bytes", "memory.usage_in_bytes",
                               "total_inactive_file", "total_active_file"};

/// What the limit of one group leaves; the word `max` is no limit.
std::uint64_t left_in_group(const fs::path& folder, const GroupFiles& files) {
  std::uint64_t limit = 0, usage = 0;
  if (!(std::ifstream(folder / files.limit) >> limit) ||
      !(std::ifstream(folder / files.usage) >> usage))
    return unknown;
  for (const char* const cache : {files.inactive, files.active})
    usage -= std::min(usage, number_after(folder / "memory.stat", cache, 0));
  return limit - std::min(limit, usage);
}

/// What the group of this process and all groups above it leave. In a container the groups' root is
/// the container's own group, whatever path /proc names.
std::uint64_t left_in_groups(const fs::path& root) {
  std::uint64_t left = unknown;
  std::ifstream file(root / "proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {  // number:controllers:/path
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const bool v2 = controllers == ",,";
    if (!v2 && controllers.find(",memory,") == std::string::npos) continue;
    const fs::path top = root / (v2 ? "sys/fs/cgroup" : "sys/fs/cgroup/memory");
    fs::path group = fs::path(line.substr(second + 1)).relative_path();
    for (;; group = group.parent_path()) {
      left = std::min(left, left_in_group(top / group, v2 ? version_2 : version_1));
      if (group.empty()) break;
    }
  }
  return left;
}

/// What `ulimit -v` and `ulimit -d` leave.
std::uint64_t left_to_process() {
  std::uint64_t all = 0, data = 0, other = 0;  // [pages]
  std::ifstream("/proc/self/statm") >> all >> other >> other >> other >> other >> data;
  const auto left = [](auto resource, std::uint64_t pages) {
    rlimit limit{};
    if (getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unknown;
    const std::uint64_t used = pages * std::uint64_t(sysconf(_SC_PAGESIZE));
    return limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, used);
  };
  return std::min(left(RLIMIT_AS, all), left(RLIMIT_DATA, data));
}

std::atomic<std::uint64_t> claim_limit = 0;

}  // namespace

std::uint64_t available_memory(const fs::path& root) {
  const std::uint64_t kibibytes = number_after(root / "proc/meminfo", "MemAvailable:", unknown);
  const std::uint64_t machine = kibibytes == unknown ? unknown : kibibytes << 10;
  const std::uint64_t left = std::min({machine, left_in_groups(root), left_to_process()});
  return left == unknown ? 0 : std::max<std::uint64_t>(left, 1);
}

void limit_claims(std::uint64_t bytes) { claim_limit = bytes; }

void claim_memory(double bytes, const std::string& what) {
  const auto refuse = [&](const char* most, std::uint64_t there) {
    throw Error(ExitCode::memory,
                what + formatted(" takes %.1f MiB of memory, and %s %s", bytes / (1 << 20), most,
                                 mebibytes(there).c_str()));
  };
  constexpr double small = 1 << 20;  // looking takes longer
  if (bytes <= small) return;
  const std::uint64_t allowed = claim_limit;
  if (allowed > 0 && bytes > double(allowed)) refuse("--memory-limit allows", allowed);
  const std::uint64_t free = available_memory();
  if (free > 0 && bytes > double(free)) refuse("free are", free);
}

bool lacks_threads(const std::exception& error) {
  return std::string_view(error.what()).ends_with(std::strerror(EAGAIN));
}

std::shared_ptr<void> pages(std::size_t bytes) {
  bytes = std::max<std::size_t>(bytes, 1);
  void* const first =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (first == MAP_FAILED) throw std::bad_alloc();
  return {first, [bytes](void* all) { munmap(all, bytes); }};
}

void give_back(void* first, std::size_t bytes) {
  const auto page = std::size_t(sysconf(_SC_PAGESIZE));
  if (std::align(page, page, first, bytes)) madvise(first, bytes / page * page, MADV_DONTNEED);
}

}  // namespace psivox
