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

TEST(TimeLeft, IsSaidOnceEnoughIsDone) {
  EXPECT_EQ(TimeLeft().text(0.5, 1), "");
  EXPECT_EQ(TimeLeft().text(0.049, 10), "") << "the first rays may be slow";
  EXPECT_EQ(TimeLeft().text(0.05, 10), ", 3:10 left");
  EXPECT_EQ(TimeLeft().text(0.01, 59), "");
  EXPECT_EQ(TimeLeft().text(0.01, 100), ", 2:45:00 left");
  EXPECT_EQ(TimeLeft().text(0.01, 86400), ", 99 days left");
  EXPECT_EQ(TimeLeft().text(0.009, 1000), "");
  EXPECT_EQ(TimeLeft().text(1, 1000), "");
}

TEST(TimeLeft, GoesByTheLastHalfOfTheTime) {
  TimeLeft left;
  std::string text;
  for (int s = 1; s <= 10; ++s) text = left.text(0.05 * s, s);
  EXPECT_EQ(text, ", 0:10 left");
  for (int s = 11; s <= 150; ++s) text = left.text(0.5 + 0.001 * (s - 10), s);
  EXPECT_EQ(text, ", 6:00 left");
}

}  // namespace
}  // namespace psivox
