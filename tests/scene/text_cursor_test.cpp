#include "scene/text_cursor.h"

#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <string>

namespace hapton {
namespace {

TEST(TextCursor, WalksWordsAndCountsLines) {
  TextCursor cursor(" a\tb \r\n\n c\\\nd \\\n e\nlast");
  EXPECT_EQ(cursor.word_in_line(), "a");
  EXPECT_EQ(cursor.word_in_line(), "b");
  EXPECT_EQ(cursor.word_in_line(), "");
  EXPECT_EQ(cursor.line(), 1U);
  EXPECT_EQ(cursor.word(), "c\\");
  EXPECT_EQ(cursor.line(), 3U);
  EXPECT_EQ(cursor.word(), "d");
  EXPECT_EQ(cursor.word_in_line(), "e");
  EXPECT_EQ(cursor.line(), 5U);
  cursor.next_line();
  EXPECT_EQ(cursor.word(), "last");
  EXPECT_TRUE(cursor.at_end());
  EXPECT_EQ(cursor.word(), "");
  cursor.next_line();
  EXPECT_TRUE(cursor.at_end());
}

TEST(TextCursor, GivesTheRestOfALineWithoutBlanksAround) {
  TextCursor cursor("o  two words \r\nnext");
  EXPECT_EQ(cursor.word_in_line(), "o");
  EXPECT_EQ(cursor.rest_of_line(), "two words");
  cursor.next_line();
  EXPECT_EQ(cursor.rest_of_line(), "next");
}

TEST(ParseNumber, TakesWholeWordsOnly) {
  double value = 0;
  for (const auto& [word, expected] : {std::pair("1.5", 1.5), {"+2", 2.0}, {"-3e2", -300.0}, {".5", 0.5}, {"1e-400", 0.0}}) {
    EXPECT_TRUE(parse_number(word, value)) << word;
    EXPECT_EQ(value, expected) << word;
  }
  EXPECT_TRUE(parse_number("1e400", value));
  EXPECT_TRUE(std::isinf(value));
  EXPECT_TRUE(parse_number("nan", value));
  EXPECT_TRUE(std::isnan(value));
  for (const char* word : {"", "+", "-", "+-1", "1,5", "1.5x", "0x10", "e5"}) EXPECT_FALSE(parse_number(word, value)) << word;
}

// A program that embeds the library may have set any locale.
TEST(ParseNumber, HasAPointInEveryLocale) {
  const std::string before = std::setlocale(LC_NUMERIC, nullptr);
  const char* locale = nullptr;
  for (const char* name : {"de_DE.UTF-8", "de_DE", "fr_FR.UTF-8", "fr_FR", "es_ES.UTF-8", "it_IT.UTF-8"}) {
    if (locale == nullptr) locale = std::setlocale(LC_NUMERIC, name);
  }
  if (locale == nullptr) GTEST_SKIP() << "no locale with a decimal comma is installed";
  for (const auto& [word, expected] : {std::pair("1.5", 1.5), {"1.5e-400", 0.0}, {"1.5e400", HUGE_VAL}, {"-1.5e400", -HUGE_VAL}}) {
    double value = 7.0;
    EXPECT_TRUE(parse_number(word, value)) << word;
    EXPECT_EQ(value, expected) << word;
  }
  std::setlocale(LC_NUMERIC, before.c_str());
}

TEST(WithoutByteOrderMark, TakesOneAway) {
  EXPECT_EQ(without_byte_order_mark("\xEF\xBB\xBFv 1"), "v 1");
  EXPECT_EQ(without_byte_order_mark("\xEF\xBB"), "\xEF\xBB");
  EXPECT_EQ(without_byte_order_mark("v 1"), "v 1");
  EXPECT_EQ(without_byte_order_mark(""), "");
}

TEST(ParseInteger, TakesWholeWordsOnly) {
  std::int64_t value = 0;
  EXPECT_TRUE(parse_integer("-42", value));
  EXPECT_EQ(value, -42);
  for (const char* word : {"", "1.0", "1e3", "99999999999999999999", "a"}) EXPECT_FALSE(parse_integer(word, value)) << word;
}

TEST(Printable, IsShortAndPlain) {
  EXPECT_EQ(printable("a\nb\x1b\xff"), "a?b??");
  EXPECT_EQ(printable(std::string(100, 'x')), std::string(40, 'x') + "...");
  EXPECT_EQ(printable(std::string(40, 'x')), std::string(40, 'x'));
  EXPECT_EQ(printable(""), "");
}

TEST(Printable, ShowsTheLettersOfEveryLanguage) {
  for (const char* name :
       {"Geh\u00e4use", "\u00c5ngstr\u00f6m", "\u03c0\u03b1\u03c1\u03ac\u03b4\u03b5\u03b9\u03b3\u03bc\u03b1", "\u90e8\u54c1 \U0001F9E9"})
    EXPECT_EQ(printable(name), name);
  std::string umlauts;
  for (int n = 0; n < 30; ++n) umlauts += "\u00e4";
  EXPECT_EQ(printable(umlauts), umlauts.substr(0, 40) + "...") << "whole letters";
  EXPECT_EQ(printable("x" + umlauts), ("x" + umlauts).substr(0, 39) + "...") << "whole letters";
}

TEST(Printable, ShowsNothingThatATerminalObeysOrThatIsNoUtf8) {
  EXPECT_EQ(printable("a\xc2\x9b[2J"), "a??[2J") << "CSI in one character";
  EXPECT_EQ(printable("a\u202ecod"), "a???cod") << "from right to left";
  EXPECT_EQ(printable("a\u2028b\u200bc"), "a???b???c");
  EXPECT_EQ(printable("\xc3"), "?") << "cut short";
  EXPECT_EQ(printable("\xc3("), "?(");
  EXPECT_EQ(printable("\xc1\xbf\xe0\x80\xaf"), "?????") << "longer than it need be";
  EXPECT_EQ(printable("\xed\xa0\x80"), "???") << "half of a pair";
  EXPECT_EQ(printable("\xf4\x90\x80\x80\xff"), "?????") << "beyond Unicode";
}

}  // namespace
}  // namespace hapton
