#include "hid/utf8.h"

#include <gtest/gtest.h>

#include <string>

namespace hapton {
namespace {

TEST(Utf8, NoTextIsEmpty) {
  EXPECT_EQ(to_utf8(nullptr), "");
  EXPECT_EQ(to_utf8(L""), "");
}

TEST(Utf8, AsciiStaysAsItIs) { EXPECT_EQ(to_utf8(L"Touch X 42~\x7F"), "Touch X 42~\x7F"); }

// The first and the last code point of each length.
TEST(Utf8, TakesAsManyBytesAsTheCodePointNeeds) {
  EXPECT_EQ(to_utf8(L"\x80"), "\xC2\x80");
  EXPECT_EQ(to_utf8(L"\x7FF"), "\xDF\xBF");
  EXPECT_EQ(to_utf8(L"\x800"), "\xE0\xA0\x80");
  EXPECT_EQ(to_utf8(L"\xFFFF"), "\xEF\xBF\xBF");
  EXPECT_EQ(to_utf8(L"\x10000"), "\xF0\x90\x80\x80");
  EXPECT_EQ(to_utf8(L"\x10FFFF"), "\xF4\x8F\xBF\xBF");
}

TEST(Utf8, KeepsTheOrderOfMixedText) {
  const std::wstring maker = std::wstring(L"M") + wchar_t(0xFC) + L"ller " + wchar_t(0x20AC) + wchar_t(0x1F590);
  EXPECT_EQ(to_utf8(maker.c_str()), "M\xC3\xBCller \xE2\x82\xAC\xF0\x9F\x96\x90");
}

}  // namespace
}  // namespace hapton
