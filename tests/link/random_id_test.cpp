#include "link/random_id.h"

#include <gtest/gtest.h>

#include <set>

namespace hapton {
namespace {

TEST(RandomIdTest, IsNeverZeroAndNeverTheSame) {
  std::set<std::uint64_t> ids;
  for (int i = 0; i < 1000; ++i) {
    ids.insert(make_random_id());
  }
  EXPECT_EQ(ids.size(), 1000U);
  EXPECT_FALSE(ids.contains(0));
}

}  // namespace
}  // namespace hapton
