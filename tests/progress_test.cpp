#include <gtest/gtest.h>

#include "../tools/notices.h"

namespace psivox {
namespace {

TEST(ProgressMarks, LongWorkIsNeverSilentForLong) {
  // 200 s of work, reported twice a second
  ProgressMarks marks(10, 2, 10);
  double last_s = 0, longest_s = 0;
  int lines = 0;
  for (double s = 0; s <= 200; s += 0.5) {
    if (!marks.passes(s / 200, s)) continue;
    longest_s = std::max(longest_s, s - last_s);
    last_s = s;
    ++lines;
    if (lines == 1) {
      EXPECT_EQ(s, 2);
    }
  }
  EXPECT_LE(longest_s, 10);
  EXPECT_LE(lines, 40);
}

TEST(ProgressMarks, ShortWorkSaysNothing) {
  ProgressMarks marks(10, 2, 10);
  for (double s = 0; s < 2; s += 0.1) EXPECT_FALSE(marks.passes(s / 2, s));
}

TEST(ProgressMarks, WorkOfAMinuteSaysItsTenths) {
  ProgressMarks marks(10, 2, 10);
  int lines = 0;
  for (int s = 0; s <= 60; ++s) lines += marks.passes(s / 60.0, s);
  EXPECT_EQ(lines, 11);  // the first after 2 s, then tenths
}

}  // namespace
}  // namespace psivox
