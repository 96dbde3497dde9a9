#include "link/marker_text.h"

#include <gtest/gtest.h>

#include <string>

namespace hapton {
namespace {

using std::string_literals::operator""s;

TEST(MarkerText, IsUtf8OfAtMostItsLength) {
  for (const std::string& text : {"trial 1"s, "a"s, "gez\xC3\xBC"s + "ckt", "\xE2\x82\xAC"s, "\xF0\x9F\x9A\x80"s, "\xF4\x8F\xBF\xBF"s,
                                  "\xC2\xA0"s, std::string(MarkerText::kMaxBytes, 'x')}) {
    EXPECT_TRUE(MarkerText::is_valid(text)) << text;
  }
  EXPECT_FALSE(MarkerText::is_valid(""));
  EXPECT_FALSE(MarkerText::is_valid(std::string(MarkerText::kMaxBytes + 1, 'x')));
}

TEST(MarkerText, IsNotWhatNoProgramShouldHaveToHandle) {
  const std::pair<std::string, const char*> bad[] = {
      {"\xC0\xAF", "overlong, 2 bytes"},
      {"\xE0\x80\xAF", "overlong, 3 bytes"},
      {"\xF0\x80\x80\xAF", "overlong, 4 bytes"},
      {"\xED\xA0\x80", "surrogate"},
      {"\xF4\x90\x80\x80", "above U+10FFFF"},
      {"\xF8\x88\x80\x80\x80", "5 bytes"},
      {"\x80", "continuation alone"},
      {"a\xC3", "cut"},
      {"\xE2\x82", "cut"},
      {"\xC3(", "no continuation"},
      {"\xFF", "no character"},
      {"a\nb", "line feed"},
      {"a\tb", "tab"},
      {"a\0b"s, "NUL"},
      {"\x7F", "DEL"},
      {"\xC2\x85", "next line"},
      {"\xC2\x9B", "control sequence introducer"},
      {"\xE2\x80\xA8", "line separator"},
      {"\xE2\x80\xA9", "paragraph separator"},
  };
  for (const auto& [text, why] : bad) EXPECT_FALSE(MarkerText::is_valid(text)) << why;
}

}  // namespace
}  // namespace hapton
