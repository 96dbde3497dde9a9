#include "link/replay_window.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace hapton {
namespace {

TEST(ReplayWindowTest, LetsEachCounterThroughOnce) {
  ReplayWindow window;
  for (std::uint64_t counter = 1; counter < 5000; ++counter) {
    ASSERT_TRUE(window.is_fresh(counter));
    window.mark(counter);
    ASSERT_FALSE(window.is_fresh(counter));
  }
}

TEST(ReplayWindowTest, ZeroIsNoCounter) {
  ReplayWindow window;
  EXPECT_FALSE(window.is_fresh(0));
  window.mark(1);
  EXPECT_FALSE(window.is_fresh(0));
}

TEST(ReplayWindowTest, ADatagramTooOldToCheckDoesNotPass) {
  ReplayWindow window;
  window.mark(ReplayWindow::kSpan + 10);
  EXPECT_FALSE(window.is_fresh(10));
  EXPECT_TRUE(window.is_fresh(11));
}

TEST(ReplayWindowTest, CheckingLeavesNoMark) {
  ReplayWindow window;
  EXPECT_TRUE(window.is_fresh(~std::uint64_t{0}));
  EXPECT_TRUE(window.is_fresh(1));
}

// Compared with a set that has no limit: a counter passes exactly if it is recent and was never marked.
TEST(ReplayWindowTest, AgreesWithASetInAnyOrder) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    ReplayWindow window;
    std::set<std::uint64_t> marked;
    std::uint64_t newest = 0;
    for (int i = 0; i < 20'000; ++i) {
      const std::uint64_t jump = random() % 100 == 0 ? random() % 3000 : random() % 4;
      const std::uint64_t back = random() % 4 == 0 ? random() % 2000 : 0;
      const std::uint64_t counter = newest + jump > back ? newest + jump - back : 1;
      const bool is_known = marked.contains(counter);
      const bool is_recent = counter + ReplayWindow::kSpan > newest;
      ASSERT_EQ(window.is_fresh(counter), is_recent && !is_known) << counter << " with newest " << newest;
      if (is_recent && !is_known) {
        window.mark(counter);
        marked.insert(counter);
        newest = std::max(newest, counter);
      }
    }
  }
}

}  // namespace
}  // namespace hapton
