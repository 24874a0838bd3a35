// The processes of guarded reading: how many there are, that none is left, and how
// long those of one file may take together.

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <utility>

#include "guard_limits.h"
#include "psivox/vdb.h"
#include "scan_made_files.h"
#include "scratch.h"
#include "thrown.h"
#include "vdb/reader.h"
#include "vdb_test_util.h"

extern char** environ;

namespace psivox::vdb {
namespace {

/// Processes in the group.
int processes_of(pid_t group) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string process = entry.path().filename().string();
    if (process.find_first_not_of("0123456789") != std::string::npos) continue;
    if (getpgid(std::stoi(process)) == group) ++count;
  }
  return count;
}

/// The parent of a process; 0 if it has ended.
pid_t parent_of(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");  // 12 (name) S 34 ...
  std::string text;
  std::getline(file, text);
  std::istringstream fields(text.empty() ? text : text.substr(text.rfind(')') + 1));
  char state = 0;
  pid_t parent = 0;
  return fields >> state >> parent ? parent : 0;
}

/// This process's children, and theirs.
int processes_below() {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string folder = entry.path().filename().string();
    if (folder.find_first_not_of("0123456789") != std::string::npos) continue;
    pid_t process = parent_of(std::stoi(folder));
    while (process > 1 && process != getpid()) process = parent_of(process);
    count += process == getpid();
  }
  return count;
}

/// The same once it stays: readers of tests before may still be ending.
int settled_processes() {
  int last = -1, now = processes_below();
  for (int same = 0; same < 5; same = now == last ? same + 1 : 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    last = std::exchange(now, processes_below());
  }
  return now;
}

TEST(GuardedReading, AnErrorLeavesTheReader) {
  const auto reader =
      open_guarded_reader(std::make_shared<FileBlocks>(test::assets_dir() / "blobs.vdb"), nullptr);
  EXPECT_EQ(reader->facts().grids.size(), 3u);
  const int before = settled_processes();
  EXPECT_THROW(reader->read("nothing", {}), Error);
  EXPECT_EQ(processes_below(), before);
}

/// Until it is so, for a minute at most: the system may take its time.
template <typename Condition>
bool becomes(const Condition& condition) {
  for (int n = 0; n < 6000; ++n) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

TEST(GuardedReading, NoProcessIsLeftWhenTheProgramIsKilled) {
  for (const int signal : {SIGKILL, SIGINT}) {
    const std::string path =
        test::write_bytes("sleep.vdb", test::file_bytes(test::assets_dir() / "single_voxel.vdb"))
            .string();
    std::string self = "/proc/self/exe", option = "--read", file = path;
    char* arguments[] = {self.data(), option.data(), file.data(), nullptr};
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    pid_t program = 0;
    ASSERT_EQ(posix_spawn(&program, self.c_str(), nullptr, &attributes, arguments, environ), 0);
    EXPECT_TRUE(becomes([&] { return processes_of(program) == 3; }))  // program, server, reader
        << processes_of(program);
    kill(program, signal);
    int status = 0;
    waitpid(program, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status));
    EXPECT_TRUE(becomes([&] { return processes_of(program) == 0; })) << processes_of(program);
    posix_spawnattr_destroy(&attributes);
  }
}

TEST(GuardedReading, FramesOfAFileThatIsOpenShareItsReader) {
  const std::string path =
      test::write_bytes("frames.nii.gz",
                        test::gzipped(test::nifti_header(false, false, 2, test::dims({3})) +
                                      test::values_of_type<std::uint8_t>(false, 1, false, 3)))
          .string();
  const int before = settled_processes();
  const auto film = file_of_frame(path + "[1]");
  ASSERT_TRUE(film);
  const VolumeFile first(path + "[0]"), last(path + "[2]");
  EXPECT_EQ(processes_below(), before + 1);
  EXPECT_NE(first.read("image").storage, last.read("image").storage);
  EXPECT_FALSE(file_of_frame(path));
}

TEST(GuardedReading, AReaderEndsWithItsVdbFile) {
  // other tests may have processes in this one's group
  const int before = settled_processes();
  {
    const VolumeFile file(test::assets_dir() / "blobs.vdb");
    EXPECT_EQ(processes_below(), before + 1);
  }
  EXPECT_TRUE(becomes([&] { return processes_below() == before; }));
}

// --- how long they may take ----------------------------------------------------------------------

using guard::sanitised;
using test::Limits;

TEST(GuardedReading, TheTimeIsThatOfTheFileNotOfAnAnswer) {
  if (sanitised) GTEST_SKIP() << "sanitizers take more time";
  const Limits limits({.seconds = 0.5, .per_mebibyte = 0});
  const auto path =
      test::write_bytes("slow.vdb", test::file_bytes(test::assets_dir() / "blobs.vdb"));
  const VolumeFile file(path);
  EXPECT_NO_THROW(file.info());
  const std::string message = input_error([&] {
    for (int i = 0; i < 3; ++i) file.read("density");
  });
  EXPECT_TRUE(has(message, "took longer than a good file"));
}

/// When the directory was read again for each grid, by a new process for each that is empty, 4,000
/// took 20 s of processor time.
TEST(GuardedReading, ThousandsOfEmptyGridsTakeTheTimeOfOneDirectory) {
  if (sanitised) GTEST_SKIP() << "sanitizers take more time";
  const auto path = test::scratch_dir() / "empty_grids.vdb";
  openvdb::GridPtrVec grids;
  for (int i = 0; i < 4000; ++i) {
    grids.push_back(openvdb::FloatGrid::create());
    grids.back()->setName("g" + std::to_string(i));
  }
  openvdb::io::File(path.string()).write(grids);
  const Limits limits({.seconds = 3, .per_mebibyte = 0});
  const VolumeFile file(path);
  EXPECT_EQ(file.info().size(), 4000u);
  EXPECT_THROW(file.default_grid(), Error);
  int refused = 0;
  for (const std::string& name : file.names())
    refused += !input_error([&] { file.read(name); }).empty();
  EXPECT_EQ(refused, 4000);
}

TEST(GuardedReading, WhatAHeaderClaimsCountsUpToWhatAFileCanHold) {
  guard::Budget budget(1 << 20);
  const guard::Limits& limits = guard::limits;
  const double known = guard::sanitised ? 10 * (limits.seconds + limits.per_mebibyte)
                                        : limits.seconds + limits.per_mebibyte;
  EXPECT_TRUE(budget.spend(known, 0));
  EXPECT_FALSE(budget.spend(1, 0));
  budget.claim(std::uint64_t{1} << 60);
  EXPECT_TRUE(budget.spend(0, 0));
  EXPECT_FALSE(budget.spend(1040 * limits.per_unpacked_mebibyte * (guard::sanitised ? 10 : 1), 0));
}

}  // namespace
}  // namespace psivox::vdb
