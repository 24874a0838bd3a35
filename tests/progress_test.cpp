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

TEST(TimeLeft, IsSaidAfterTenSecondsHoweverLittleIsDone) {
  EXPECT_EQ(TimeLeft().text(0.01, 5), "");
  EXPECT_EQ(TimeLeft().text(0.01, 10), ", 16:30 left");
  EXPECT_EQ(TimeLeft().text(0.001, 10), ", 2:46:30 left");
  EXPECT_EQ(TimeLeft().text(1e-5, 10), ", 12 days left");
  EXPECT_EQ(TimeLeft().text(0, 1000), "");
}

TEST(TimeLeft, IsThatOfTheStage) {
  TimeLeft left;
  for (int s = 1; s <= 10; ++s) left.text(0.05 * s, s);  // light
  std::string text;
  for (int s = 11; s <= 40; ++s) text = left.text(0.5, s);
  EXPECT_EQ(text, "");  // the march's first tile
  for (int s = 41; s <= 150; ++s) text = left.text(0.5 + 0.001 * (s - 40), s);
  EXPECT_EQ(text, ", 6:30 left");
}

}  // namespace
}  // namespace psivox
