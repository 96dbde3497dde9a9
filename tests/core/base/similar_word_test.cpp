#include "core/base/similar_word.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>

namespace hapton {
namespace {

TEST(SimilarWord, NamesTheNearestOrAll) {
  const std::array<std::string_view, 3> known = {"friction_static", "friction_dynamic", "scale"};
  EXPECT_EQ(similar_word_hint("friction_statik", known), "; did you mean 'friction_static'?");
  EXPECT_EQ(similar_word_hint("frictiondynamic", known), "; did you mean 'friction_dynamic'?");
  EXPECT_EQ(similar_word_hint("scal", known), "; did you mean 'scale'?");
  EXPECT_EQ(similar_word_hint("sclae", known), "; did you mean 'scale'?");
  EXPECT_EQ(similar_word_hint("volume", known), "; known are friction_static, friction_dynamic, scale");
  EXPECT_EQ(similar_word_hint(std::string(100000, 'x'), known), "; known are friction_static, friction_dynamic, scale");
}

TEST(SimilarWord, FindsTheNearestWordOrNone) {
  constexpr std::array<std::string_view, 3> known = {"--scene", "--seconds", "--out"};
  EXPECT_EQ(find_similar_word("--sceen", known), "--scene");
  EXPECT_EQ(find_similar_word("--second", known), "--seconds");
  EXPECT_EQ(find_similar_word("--volume", known), "");
}

// A known word is similar if it is at most two changes away, or a third of the letters of the given word.
TEST(SimilarWord, ALongWordMayBeFartherOff) {
  const auto found = [](std::string_view word, std::string_view known) { return find_similar_word(word, std::array{known}) == known; };
  EXPECT_TRUE(found("abc", "abXYc"));
  EXPECT_FALSE(found("abc", "abXYZc"));
  EXPECT_TRUE(found("abcdefgh", "abXYefgh"));
  EXPECT_FALSE(found("abcdefgh", "aXYZefgh"));
  EXPECT_TRUE(found("abcdefghi", "aXYZefghi"));
  EXPECT_FALSE(found("abcdefghi", "XYZWefghi"));
  EXPECT_TRUE(found("", "ab"));
  EXPECT_FALSE(found("", "abc"));
}

// An insertion, a deletion and a change count one each, wherever in the word they are.
TEST(SimilarWord, TheFewestChangesWin) {
  struct Row {
    const char* word;
    const char* nearer;
    const char* farther;
  };
  const Row rows[] = {{"force", "forc", "fort"},   {"force", "xforce", "xxforce"},  {"force", "farce", "fancy"},
                      {"force", "orce", "rce"},    {"kitten", "sitten", "sitting"}, {"abcd", "abXcd", "abXYcd"},
                      {"abcdef", "abdf", "abYZWf"}};
  for (const Row& row : rows) {
    EXPECT_EQ(find_similar_word(row.word, std::array<std::string_view, 2>{row.farther, row.nearer}), row.nearer) << row.word;
    EXPECT_EQ(find_similar_word(row.word, std::array<std::string_view, 2>{row.nearer, row.farther}), row.nearer) << row.word;
  }
  EXPECT_EQ(find_similar_word("farce", std::array<std::string_view, 2>{"force", "farme"}), "force") << "of equals the first";
}

TEST(SimilarWord, AWordOfFourLettersMayBeABeginning) {
  constexpr std::array<std::string_view, 2> known = {"stiff", "stiffness_n_per_m"};
  EXPECT_EQ(find_similar_word("stiffness", known), "stiffness_n_per_m");
  EXPECT_EQ(find_similar_word("stif", std::array<std::string_view, 1>{"stiffness_n_per_m"}), "stiffness_n_per_m");
  EXPECT_EQ(find_similar_word("sti", std::array<std::string_view, 1>{"stiffness_n_per_m"}), "");
  EXPECT_EQ(find_similar_word("forces", std::array<std::string_view, 2>{"farces", "forces_of_all"}), "forces_of_all")
      << "and is nearer than any";
}

// A word of more than 64 letters is not compared, because the time grows with the product of the lengths.
TEST(SimilarWord, AWordThatIsTooLongIsNearNothing) {
  const std::string word(64, 'x');
  EXPECT_EQ(find_similar_word(word, std::array<std::string_view, 1>{std::string_view(word).substr(1)}), std::string_view(word).substr(1));
  const std::string longer(65, 'x');
  EXPECT_EQ(find_similar_word(longer, std::array<std::string_view, 1>{std::string_view(longer).substr(1)}), "");
}

}  // namespace
}  // namespace hapton
