#include "core/base/valid_utf8.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

using namespace std::string_view_literals;

TEST(ValidUtf8, KeepsWhatIsUtf8) {
  for (const std::string_view text : {""sv, "caf\xC3\xA9.csv"sv, "\xE2\x82\xAC"sv, "\xF0\x9F\x98\x80"sv, "a\0b"sv}) {
    EXPECT_EQ(to_valid_utf8(text), text);
  }
}

TEST(ValidUtf8, TakesOtherBytesForLatin1) {
  EXPECT_EQ(to_valid_utf8("caf\xE9.csv"), "caf\xC3\xA9.csv");
  EXPECT_EQ(to_valid_utf8("\xC3"), "\xC3\x83") << "cut off";
  EXPECT_EQ(to_valid_utf8("\xC0\x80"), "\xC3\x80\xC2\x80") << "an overlong form";
  EXPECT_EQ(to_valid_utf8("\xED\xA0\x80"), "\xC3\xAD\xC2\xA0\xC2\x80") << "a surrogate";
  EXPECT_EQ(to_valid_utf8("\xF4\x90\x80\x80"), "\xC3\xB4\xC2\x90\xC2\x80\xC2\x80") << "above U+10FFFF";
}

// RFC 3629, section 4: the first and the last code points of each length are valid, those just outside are not.
TEST(ValidUtf8, LengthsAreThoseOfTheStandard) {
  for (const std::string_view text : {"\xC2\x80"sv, "\xDF\xBF"sv, "\xE0\xA0\x80"sv, "\xED\x9F\xBF"sv, "\xEE\x80\x80"sv, "\xEF\xBF\xBF"sv,
                                      "\xF0\x90\x80\x80"sv, "\xF1\x80\x80\x80"sv, "\xF4\x8F\xBF\xBF"sv}) {
    EXPECT_EQ(utf8_length(text), text.size()) << text;
    EXPECT_EQ(utf8_length(text.substr(0, text.size() - 1)), 0U) << "cut off";
    for (const char other : {'\x7F', '\xC0'}) EXPECT_EQ(utf8_length(std::string(text.substr(0, text.size() - 1)) + other), 0U);
  }
  for (const std::string_view text : {"\x80"sv, "\xC1\xBF"sv, "\xE0\x9F\xBF"sv, "\xED\xA0\x80"sv, "\xF0\x8F\xBF\xBF"sv,
                                      "\xF4\x90\x80\x80"sv, "\xF5\x80\x80\x80"sv, "\xE1\x80"sv, "\xF1\x80\x7F\x80"sv}) {
    EXPECT_EQ(utf8_length(text), 0U);
  }
}

TEST(ValidUtf8, OfAnyBytesIsValid) {
  constexpr unsigned kSeed = 5;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937 random(kSeed);
  for (int i = 0; i < 20'000; ++i) {
    std::string bytes(random() % 9, ' ');
    for (char& byte : bytes) byte = static_cast<char>(random() % 4 == 0 ? random() : 0x80 | (random() & 0x7F));
    const std::string valid = to_valid_utf8(bytes);
    for (std::string_view rest = valid; !rest.empty();) {
      const std::size_t length = utf8_length(rest);
      ASSERT_GT(length, 0U) << i;
      rest.remove_prefix(length);
    }
    ASSERT_EQ(to_valid_utf8(valid), valid) << i;
  }
}

}  // namespace
}  // namespace hapton
