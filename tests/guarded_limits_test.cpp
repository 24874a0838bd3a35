// How long the processes that read one file may take: one budget for the file.

#include <gtest/gtest.h>

#include <string>

#include "guard_limits.h"
#include "psivox/vdb.h"
#include "scratch.h"
#include "thrown.h"
#include "vdb_test_util.h"

namespace psivox::vdb {
namespace {

using guard::sanitised;
using test::Limits;

TEST(GuardedReading, TheTimeIsThatOfTheFileNotOfAnAnswer) {
  if (sanitised) GTEST_SKIP() << "sanitizers take more time";
  const Limits limits({.seconds = 0.5, .per_mebibyte = 0});
  const auto path =
      test::write_bytes("slow.vdb", test::file_bytes(test::assets_dir() / "blobs.vdb"));
  const VdbFile file(path);
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
  const VdbFile file(path);
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
