#include "scene/text_cursor.h"

#include <gtest/gtest.h>

#include <cmath>

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

TEST(ParseInteger, TakesWholeWordsOnly) {
  std::int64_t value = 0;
  EXPECT_TRUE(parse_integer("-42", value));
  EXPECT_EQ(value, -42);
  for (const char* word : {"", "1.0", "1e3", "99999999999999999999", "a"}) EXPECT_FALSE(parse_integer(word, value)) << word;
}

TEST(Printable, IsShortAndPlain) {
  EXPECT_EQ(printable("a\nb\x1b\xff"), "a?b??");
  EXPECT_EQ(printable(std::string(100, 'x')), std::string(40, 'x') + "...");
}

}  // namespace
}  // namespace hapton
