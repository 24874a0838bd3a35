#include "base/text.h"

#include <gtest/gtest.h>

#include <cstdio>

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

TEST(Text, HtmlHasNoMarkupOfAText) {
  EXPECT_EQ(html_text("<b a=\"x\" b='y'>&"), "&lt;b a=&quot;x&quot; b=&#39;y&#39;&gt;&amp;");
}

TEST(Text, SplitAndJoinedAreInverse) {
  EXPECT_EQ(split(""), Items{});
  EXPECT_EQ(split("a"), Items{"a"});
  EXPECT_EQ(split("a,,b"), (Items{"a", "", "b"}));
  EXPECT_EQ(split("1|2,3", '|'), (Items{"1", "2,3"}));
  EXPECT_EQ(joined(Items{}), "");
  EXPECT_EQ(joined(Items{"", "a", ""}), ",a,");
  EXPECT_EQ(joined(split("x|y|z", '|'), " or "), "x or y or z");
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

TEST(Text, NumbersReadBackAsTheSameBits) {
  for (const double value : {0.1, -1e-300, 1.0 / 3, 1e22, 0.0}) {
    double back = 1;
    EXPECT_TRUE(read_number(number_text(value), back));
    EXPECT_EQ(back, value);
  }
  EXPECT_EQ(number_text(0.1f), "0.1");
  int whole = 0;
  for (const char* text : {"", "1.5", "1 ", " 1", "x", "99999999999"})
    EXPECT_FALSE(read_number(text, whole)) << text;
}

TEST(Text, FormattedIsAsLongAsItMustBe) {
  EXPECT_EQ(formatted("%.1e|%s", 0.25, std::string(2000, 'x').c_str()),
            "2.5e-01|" + std::string(2000, 'x'));
  EXPECT_EQ(formatted("%%"), "%");
}

}  // namespace
}  // namespace psivox
