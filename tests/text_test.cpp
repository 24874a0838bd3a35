#include "base/text.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "../tools/notices.h"

namespace psivox {
namespace {

using Items = std::vector<std::string>;

TEST(Text, QuotesShowWhatAMessageOfOneLineCannotHold) {
  EXPECT_EQ(in_quotes("a b.vdb"), "'a b.vdb'");
  EXPECT_EQ(in_quotes("a\nb\x7f"), "'a\\x0ab\\x7f'");
  EXPECT_EQ(in_quotes("\xc3\xa4"), "'\xc3\xa4'");  // UTF-8 stays
  EXPECT_EQ(printable("\xf0\x9f\x99\x82 \xe2\x89\xa4"), "\xf0\x9f\x99\x82 \xe2\x89\xa4");
  EXPECT_EQ(printable("\xc2\x9b \xe2\x80\xae \xe2\x80\xa8"), R"(\u009b \u202e \u2028)");
  // bytes that are no UTF-8: alone, cut short, too long a form, a surrogate, beyond the last letter
  EXPECT_EQ(printable("\x9b"), R"(\x9b)");
  EXPECT_EQ(printable("\xe2\x80"), R"(\xe2\x80)");
  EXPECT_EQ(printable("\xc0\x9b"), R"(\xc0\x9b)");
  EXPECT_EQ(printable("\xed\xa0\x80"), R"(\xed\xa0\x80)");
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), R"(\xf4\x90\x80\x80)");
}

TEST(Text, AWordOfAShellIsThatWord) {
  EXPECT_EQ(shell_word("--step=0.5"), "--step=0.5");
  EXPECT_EQ(shell_word("=ls"), "'=ls'");  // zsh looks for a program
  for (const std::string word : {"a b", "", "$(touch X)", "`id`", "a'b", "a\\b", "a;b|c&d", "~",
                                 "#", "!!", "*", "a\nb", "\x1b[2J'\\x", "\xc2\x9bm",
                                 "\xff\xfe"
                                 "9",
                                 "\xc3\xa4"}) {
    const std::string quoted = shell_word(word);
    EXPECT_EQ(printable(quoted), quoted);
    std::FILE* const shell =
        popen(("bash -c \"$(cat <<'END'\nprintf %s " + quoted + "\nEND\n)\"").c_str(), "r");
    std::string read(100, '\0');
    read.resize(std::fread(read.data(), 1, read.size(), shell));
    pclose(shell);
    EXPECT_EQ(read, word) << quoted;
  }
}

TEST(Text, TheNearestNameIsTheOneMeant) {
  const Items names = {"step",           "sampling",      "segments",  "camera-position",
                       "luminance-grid", "emission-grid", "resolution"};
  EXPECT_EQ(nearest_name("setp", names), "step");
  EXPECT_EQ(nearest_name("steps", names), "step");
  EXPECT_EQ(nearest_name("resolutoin", names), "resolution");
  EXPECT_EQ(nearest_name("LUMINANCE_GRID", names), "luminance-grid");
  EXPECT_EQ(nearest_name("camera-pos", names), "camera-position");
  EXPECT_EQ(nearest_name("xyzzy", names), "");
  EXPECT_EQ(nearest_name("", names), "");
  EXPECT_EQ(suggestion("setp", names), "; did you mean step?");
  EXPECT_EQ(suggestion("xyzzy", names), "");
}

TEST(Text, NearNamesComeFirstAndTheRestKeepTheirOrder) {
  const Items names = {"heat", "flame", "density", "v"};
  EXPECT_EQ(nearest_first("desnity", names), (Items{"density", "heat", "flame", "v"}));
  EXPECT_EQ(nearest_first("density", Items{}), Items{});
  EXPECT_EQ(nearest_first("fla", names).front(), "flame");  // `v` is nearer by letters alone
}

// --- progress ------------------------------------------------------------------------------------

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
