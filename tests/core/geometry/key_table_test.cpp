#include "core/geometry/key_table.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace hapton {
namespace {

// The table gives the same numbers as an ordered map, however small its initial size is.
TEST(KeyTable, GivesEachKeyItsFirstNumber) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  for (const std::size_t expected_count : {std::size_t{0}, std::size_t{20'000}}) {
    KeyTable<2> table(expected_count);
    std::map<KeyTable<2>::Key, std::uint32_t> expected;
    for (std::uint32_t n = 0; n < 20'000; ++n) {
      const KeyTable<2>::Key key = {random() % 100, random() % 100};
      ASSERT_EQ(table.contains(key), expected.contains(key));
      const std::uint32_t first = expected.try_emplace(key, n).first->second;
      ASSERT_EQ(table.find_or_add(key, n), first);
    }
    for (const auto& [key, number] : expected) ASSERT_EQ(table.find_or_add(key, 30'000), number);
    EXPECT_FALSE(table.contains({100, 100}));
  }
}

TEST(KeyTable, BothZerosAreOneKey) {
  EXPECT_EQ(words_of(Vec3(0.0, 1.0, -0.0)), words_of(Vec3(-0.0, 1.0, 0.0)));
  EXPECT_NE(words_of(Vec3(0.0, 1.0, 0.0)), words_of(Vec3(0.0, -1.0, 0.0)));
}

}  // namespace
}  // namespace hapton
