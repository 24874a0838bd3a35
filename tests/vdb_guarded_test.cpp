// Reading in a guarded process: whatever happens there is one Error(input), and what comes back is
// what reading in place gives.

#include <fcntl.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <ctime>
#include <fstream>
#include <functional>
#include <map>
#include <thread>

#include "field/leaf_values.h"
#include "field/value_range.h"
#include "guard/pack.h"
#include "guard/service.h"
#include "guard_limits.h"
#include "psivox/vdb.h"
#include "scratch.h"
#include "thrown.h"
#include "vdb/reader.h"
#include "vdb/reading_messages.h"
#include "vdb_test_util.h"

namespace psivox::vdb {
namespace {

using guard::MessageKind;
using guard::packed;
using guard::sanitised;

using test::Limits;
using test::same;

/// Hides what it does from the compiler.
volatile int* volatile nowhere = nullptr;
char* volatile seen = nullptr;

void send_answer(int connection, const std::string& content) {
  const guard::Descriptor memory = guard::shared_copy(content);
  guard::send(connection, packed(MessageKind::data), std::array{memory.get()});
  std::this_thread::sleep_for(std::chrono::hours(1));
}

void send_failure(int connection, const std::string& message) {
  guard::send(connection, packed(MessageKind::failure, 3, message, false));
}

/// Sends what of a process should be possible: 1, and what should not.
void try_forbidden_calls(int connection) {
  const int file = open("/etc/passwd", O_RDONLY);
  const int socket_ = socket(AF_INET, SOCK_STREAM, 0);
  const pid_t child = fork();
  if (child == 0) _exit(0);
  const bool killed = kill(getppid(), 0) == 0;
  std::string answer = "opened " + std::to_string(file >= 0) + ", connected " +
                       std::to_string(socket_ >= 0) + ", forked " + std::to_string(child > 0) +
                       ", signalled " + std::to_string(killed);
  std::thread([&] { answer += ", in a thread"; }).join();
  send_failure(connection, answer);
}

/// Uses the processor for a time [s].
void be_busy(double seconds) {
  const std::clock_t end = std::clock() + std::clock_t(seconds * CLOCKS_PER_SEC);
  while (std::clock() < end) continue;
}

/// What a file does to its reader, by the file's name.
const std::map<std::string, std::function<void(int connection)>> accidents = {
    {"segfault.vdb", [](int) { *nowhere = 1; }},
    {"abort.vdb", [](int) { std::abort(); }},
    {"terminate.vdb", [](int) { std::thread([] { throw 1; }).join(); }},
    {"exit.vdb", [](int) { _exit(0); }},
    {"killed.vdb", [](int) { raise(SIGKILL); }},
    {"hang.vdb",
     [](int) {
       while (!nowhere) continue;
     }},
    {"sleep.vdb", [](int) { std::this_thread::sleep_for(std::chrono::hours(1)); }},
    {"naps.vdb",
     [](int) {
       for (;;) {
         std::this_thread::sleep_for(std::chrono::milliseconds(20));
         be_busy(1e-3);
       }
     }},
    {"slow.vdb", [](int) { be_busy(0.2); }},
    {"overflow.vdb",
     [](int) {
       std::vector<char> huge(std::size_t{1} << 44);
       seen = huge.data();  // or a compiler leaves it out
     }},
    {"nonsense.vdb", [](int connection) { send_answer(connection, "nonsense"); }},
    {"empty_answer.vdb", [](int connection) { send_answer(connection, ""); }},
    {"long_answer.vdb",
     [](int connection) { send_answer(connection, std::string(65 << 20, 'x')); }},
    {"no_memory.vdb",
     [](int connection) {
       guard::send(connection, packed(MessageKind::data));
       std::this_thread::sleep_for(std::chrono::hours(1));
     }},
    {"unknown.vdb",
     [](int connection) {
       guard::send(connection, "\x7fwhat");
       std::this_thread::sleep_for(std::chrono::hours(1));
     }},
    {"lines.vdb", [](int connection) { send_failure(connection, "two\nlines\x1b[2J"); }},
    {"calls.vdb", try_forbidden_calls},
};

void have_accident(const std::string& path, std::string_view bytes, int connection) {
  const std::string name = std::filesystem::path(path).filename().string();
  const auto accident = accidents.find(name);
  if (accident != accidents.end()) accident->second(connection);
  // in one grid of several, and where all are asked for
  Request request;
  guard::unpack(bytes, request);
  const auto asks = [&](auto grid) { return bytes.find(grid) != bytes.npos; };
  if (name == "bad_color.vdb" && request.what != Request::What::facts && !asks("density") &&
      !asks("temperature"))
    *nowhere = 1;
  if (name == "all_bad.vdb" && request.what == Request::What::info) *nowhere = 1;
}

std::filesystem::path asset(const std::string& name) { return test::assets_dir() / name; }

/// A file of that name, with the content of an asset.
std::filesystem::path file_named(const std::string& name) {
  return test::write_bytes(name, test::file_bytes(asset("single_voxel.vdb")));
}

/// All that reading says, errors too, but for leaves and tiles.
std::string facts_of(Reader& reader, const std::string& grid, const ReadOptions& options,
                     Field& field) {
  try {
    field = reader.read(grid, options);
    return packed(field);
  } catch (const Error& error) {
    return error.what();
  }
}

/// What GridContent says, or the error.
std::string content_of(Reader& reader, const std::string& grid) {
  try {
    return packed(reader.content(grid));
  } catch (const Error& error) {
    return error.what();
  }
}

void expect_same_as_in_place(const std::filesystem::path& path) {
  const auto file = std::make_shared<FileBlocks>(path);
  const auto in_place = open_reader(file, nullptr), guarded = open_guarded_reader(file, nullptr);
  ASSERT_TRUE(guarded);
  EXPECT_EQ(packed(in_place->facts()), packed(guarded->facts()));
  for (const auto& [grid, base, channels, type, of_class, place] : in_place->facts().grids) {
    EXPECT_EQ(packed(in_place->info(grid, true), in_place->info(grid, false)),
              packed(guarded->info(grid, true), guarded->info(grid, false)))
        << grid;
    EXPECT_EQ(content_of(*in_place, grid), content_of(*guarded, grid)) << grid;
    for (const GridRole role : {GridRole::data, GridRole::attenuation}) {
      for (const bool distances : {false, true}) {
        const ReadOptions options{
            .role = role, .distances = distances, .background = 0.5, .percentiles = {50.0}};
        Field a, b;
        ASSERT_EQ(facts_of(*in_place, grid, options, a), facts_of(*guarded, grid, options, b))
            << grid;
        EXPECT_TRUE(same(a.leaves, b.leaves, a.channels)) << grid;
        EXPECT_TRUE(same(a.tiles, b.tiles)) << grid;
      }
    }
  }
}

TEST(GuardedReading, GivesWhatReadingInPlaceGives) {
  int files = 0;
  for (const auto& folder : {test::assets_dir(), test::data_dir(), test::data_dir() / "edge"}) {
    if (!std::filesystem::is_directory(folder)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() != ".vdb") continue;
      SCOPED_TRACE(entry.path());
      expect_same_as_in_place(entry.path());
      ++files;
    }
  }
  EXPECT_GE(files, 6);
}

/// Mappings of values that came from a guarded process.
int shared_mappings() {
  std::ifstream maps("/proc/self/maps");
  int count = 0;
  for (std::string line; std::getline(maps, line);)
    count += line.find("psivox answer") != line.npos;
  return count;
}

TEST(GuardedReading, ValuesThatAreDroppedLeaveSharedMemory) {
  const int before = shared_mappings();
  Field field = VolumeFile(asset("blobs.vdb")).read("density");
  EXPECT_EQ(shared_mappings(), before + 1);
  field.storage.drop_before(field.storage.leaves);
  EXPECT_EQ(shared_mappings(), before);
}

TEST(GuardedReading, EveryVdbFileIsGuardedOnceItHasStarted) {
  if (sanitised) GTEST_SKIP() << "sanitizers end a process in their own way";
  EXPECT_EQ(reading_guard(), "seccomp and resource limits");
  const std::string message = input_error([] { VolumeFile file(file_named("segfault.vdb")); });
  EXPECT_TRUE(has(message, "segfault.vdb: is damaged: reading it crashed (Segmentation fault)"));
}

TEST(GuardedReading, AnAccidentOfTheReaderIsAnErrorInOneLineThatNamesTheFile) {
  if (sanitised) GTEST_SKIP() << "sanitizers end a process in their own way";
  const Limits limits({.seconds = 0.3, .per_mebibyte = 0, .idle = 0.5, .idle_per_second = 0});
  const std::map<std::string, std::string> expected = {
      {"abort.vdb", "reading it crashed (Aborted)"},
      {"terminate.vdb", "reading it crashed (Aborted)"},
      {"exit.vdb", "its reader ended without an answer"},
      {"killed.vdb", "for lack of memory"},
      {"hang.vdb", "--trust reads without limits"},
      {"sleep.vdb", "--trust reads without limits"},
      {"naps.vdb", "--trust reads without limits"},
      {"overflow.vdb", "asks for more memory than there is"},
      {"nonsense.vdb", "its reader answered nonsense"},
      {"empty_answer.vdb", "its reader answered nonsense"},
      {"long_answer.vdb", "its reader answered nonsense"},
      {"no_memory.vdb", "its reader answered nonsense"},
      {"unknown.vdb", "its reader answered nonsense"},
  };
  for (const auto& [name, part] : expected) {
    const auto path = file_named(name);
    const std::string message = input_error([&] { VolumeFile file(path); });
    EXPECT_EQ(message.find(path.string() + ": "), 0u) << message;
    EXPECT_TRUE(has(message, part));
  }
}

TEST(GuardedReading, ACrashInOneGridLeavesTheRowsOfTheOthers) {
  if (sanitised) GTEST_SKIP() << "sanitizers end a process in their own way";
  const VolumeFile file(test::write_bytes("bad_color.vdb", test::file_bytes(asset("blobs.vdb"))));
  const std::vector<GridInfo> expected = VolumeFile(asset("blobs.vdb")).info();
  const std::vector<GridInfo> rows = file.info();
  ASSERT_EQ(rows.size(), expected.size());
  ASSERT_GE(rows.size(), 2u);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].name, expected[i].name);
    if (rows[i].name == "color") {
      EXPECT_EQ(rows[i].problem, "is damaged: reading it crashed (Segmentation fault)");
    } else {
      EXPECT_EQ(rows[i].problem, "");
      EXPECT_EQ(rows[i].active_voxels, expected[i].active_voxels);
    }
  }
  const std::string message = input_error([&] { file.read("color"); });
  EXPECT_TRUE(has(message, "bad_color.vdb: grid 'color' is damaged: reading it"));
}

TEST(GuardedReading, AFileWhoseGridsAllCrashTakesTheTimeOfAFew) {
  if (sanitised) GTEST_SKIP() << "sanitizers end a process in their own way";
  const VolumeFile file(test::write_bytes("all_bad.vdb", test::file_bytes(asset("blobs.vdb"))));
  const std::vector<GridInfo> rows = file.info();
  ASSERT_EQ(rows.size(), 3u);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_TRUE(has(rows[i].problem, "crashed"));
  EXPECT_EQ(rows[2].problem, "was not read, because reading other grids failed");
}

/// From now on the kernel gives this process no filter of calls.
void deny_seccomp() {
  const auto field = [](std::size_t offset) {
    return sock_filter(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, unsigned(offset)));
  };
  const auto unless = [](unsigned value, unsigned char skipped) {
    return sock_filter(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, skipped));
  };
  const auto end = [](unsigned action) { return sock_filter(BPF_STMT(BPF_RET | BPF_K, action)); };
  sock_filter code[] = {field(offsetof(seccomp_data, nr)),   unless(SYS_seccomp, 1),
                        end(SECCOMP_RET_ERRNO | EPERM),      unless(SYS_prctl, 3),
                        field(offsetof(seccomp_data, args)), unless(PR_SET_SECCOMP, 1),
                        end(SECCOMP_RET_ERRNO | EPERM),      end(SECCOMP_RET_ALLOW)};
  const sock_fprog program{std::size(code), code};
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
}

/// What such a process says, in place of the exit code's success.
std::string found_without_seccomp(const std::string& path) {
  if (reading_guard() != "resource limits, without seccomp") return reading_guard();
  VolumeFile(path).read("density");
  trust_files(Trust::no);
  const std::string message = input_error([&] { VolumeFile file(path); });
  return message.find("as --trust=no demands") == message.npos ? "read: " + message : "";
}

TEST(GuardedReading, WhereTheKernelRefusesSeccompItIsSaidAndCanBeRefused) {
  if (sanitised) GTEST_SKIP() << "no seccomp under sanitizers";
  const std::string self = std::filesystem::read_symlink("/proc/self/exe");
  EXPECT_EQ(std::system(
                ("'" + self + "' --without-seccomp '" + asset("blobs.vdb").string() + "'").c_str()),
            0);
  trust_files(Trust::no);
  EXPECT_NO_THROW(VolumeFile(asset("blobs.vdb")).read("density"));
  trust_files(Trust::if_needed);
}

TEST(GuardedReading, WhatAReaderSaysIsOneLine) {
  EXPECT_EQ(input_error([] { VolumeFile file(file_named("lines.vdb")); }),
            R"(two\x0alines\x1b[2J)");
}

TEST(GuardedReading, AReaderHasThreadsButReachesNoFileNoNetworkAndNoProcess) {
  if (sanitised) GTEST_SKIP() << "no seccomp under sanitizers";
  EXPECT_EQ(input_error([] { VolumeFile file(file_named("calls.vdb")); }),
            "opened 0, connected 0, forked 0, signalled 0, in a thread");
}

TEST(GuardedReading, ProgressComesBackAndMayEndTheReading) {
  struct Cancelled {};
  bool cancel = false;
  int reports = 0;
  const VolumeFile file(asset("blobs.vdb"), [&](double fraction) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    ++reports;
    if (cancel) throw Cancelled();
  });
  const Field before = file.read("density");
  EXPECT_GT(reports, 0);
  cancel = true;
  EXPECT_THROW(file.read("temperature"), Cancelled);
  cancel = false;
  EXPECT_TRUE(same(file.read("density").leaves, before.leaves, 1));
}

TEST(GuardedReading, LeavesThatStayInTheFileAreReadThere) {
  const Field whole = VolumeFile(asset("blobs.vdb")).read("density");
  const Field stored = VolumeFile(asset("blobs.vdb")).read("density", {.memory = 1});
  ASSERT_TRUE(stored.reader);
  EXPECT_EQ(active_range(stored), active_range(whole));
  EXPECT_EQ(stored.stored_range, whole.stored_range);
  EXPECT_TRUE(same(part_of_field(stored, whole.active_box).leaves,
                   part_of_field(whole, whole.active_box).leaves, 1));
}

TEST(GuardedReading, SeveralThreadsMayRead) {
  const VolumeFile shared(asset("blobs.vdb"));
  const Field expected = shared.read("density");
  std::vector<std::thread> threads;
  for (int n = 0; n < 4; ++n)
    threads.emplace_back([&] {
      for (int i = 0; i < 5; ++i) {
        EXPECT_TRUE(same(shared.read("density").leaves, expected.leaves, 1));
        EXPECT_TRUE(
            same(VolumeFile(asset("blobs.vdb")).read("density").leaves, expected.leaves, 1));
      }
    });
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace psivox::vdb

int main(int argc, char** argv) {
  const bool denied = argc == 3 && std::string(argv[1]) == "--without-seccomp";
  if (denied) psivox::vdb::deny_seccomp();
  psivox::guard::before_answer = psivox::vdb::have_accident;
  psivox::start_guarded_reading();
  if (denied) {
    const std::string found = psivox::vdb::found_without_seccomp(argv[2]);
    std::fputs(found.c_str(), stderr);
    return found.empty() ? 0 : 1;
  }
  if (argc == 3 && std::string(argv[1]) == "--read") {
    const psivox::VolumeFile file(argv[2]);
    return 0;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
