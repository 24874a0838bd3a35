// The memory that is left, under made-up files of the system.

#include "base/memory.h"
#include "scratch.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <system_error>

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// A root of /proc and /sys with 1000 KiB of memory available.
class Root {
 public:
  explicit Root(const std::string& groups) {
    write("proc/meminfo", "MemTotal: 9000 kB\nMemAvailable: 1000 kB\n");
    write("proc/self/cgroup", groups);
  }
  void write(const std::string& path, const std::string& text) const {
    test::write_bytes(path, text);
  }
  std::uint64_t left() const { return available_memory(root_); }

 private:
  fs::path root_ = test::empty_scratch_dir();
};

TEST(Memory, IsTheMachinesWithoutALimit) {
  const Root root("0::/\n");
  EXPECT_EQ(root.left(), 1000 * 1024);
  root.write("sys/fs/cgroup/memory.max", "max\n");
  root.write("sys/fs/cgroup/memory.current", "500000\n");
  EXPECT_EQ(root.left(), 1000 * 1024);
}

TEST(Memory, IsWhatTheGroupLeavesWithoutItsFileCache) {
  const Root root("0::/user/job\n");
  root.write("sys/fs/cgroup/user/job/memory.max", "700000\n");
  root.write("sys/fs/cgroup/user/job/memory.current", "300000\n");
  root.write("sys/fs/cgroup/user/job/memory.stat",
             "anon 150000\ninactive_file 100000\nactive_file 50000\n");
  EXPECT_EQ(root.left(), 550000);
  // a group above has less
  root.write("sys/fs/cgroup/user/memory.max", "400000\n");
  root.write("sys/fs/cgroup/user/memory.current", "399000\n");
  EXPECT_EQ(root.left(), 1000);
  root.write("sys/fs/cgroup/user/memory.current", "500000\n");
  EXPECT_EQ(root.left(), 1);  // 0 would be unknown
}

TEST(Memory, IsWhatTheContainersGroupOfVersion1Leaves) {
  // the path is that outside the container
  const Root root("4:cpu:/docker/x\n3:hugetlb,memory:/docker/x\n");
  root.write("sys/fs/cgroup/memory/memory.limit_in_bytes", "700000\n");
  root.write("sys/fs/cgroup/memory/memory.usage_in_bytes", "300000\n");
  root.write("sys/fs/cgroup/memory/memory.stat",
             "cache 5\ntotal_active_file 9000\ntotal_inactive_file 50000\n");
  EXPECT_EQ(root.left(), 459000);
  root.write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(root.left(), 1000 * 1024);
}

TEST(Memory, IsUnknownWithoutTheSystemsFiles) {
  EXPECT_EQ(available_memory(test::scratch_dir() / "no_root"), 0);
}

TEST(Memory, AThreadThatTheSystemDoesNotGiveIsKnownByItsWords) {
  const std::string words = std::strerror(EAGAIN);
  EXPECT_TRUE(lacks_threads(std::system_error(EAGAIN, std::generic_category())));
  EXPECT_TRUE(lacks_threads(std::runtime_error("pthread_create has failed: " + words)));
  EXPECT_FALSE(lacks_threads(std::runtime_error("an impossible least value")));
}

}  // namespace
}  // namespace psivox
