#include "io_node/work_share.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

// Works for while_ns whenever it may, beginning at from_ns after a rest. Returns the time that it worked.
std::int64_t work_for(WorkShare& share, std::int64_t from_ns, std::int64_t while_ns, std::int64_t piece_ns) {
  std::int64_t sum_ns = 0;
  for (std::int64_t now_ns = from_ns; now_ns < from_ns + while_ns;) {
    const bool may_begin = share.may_begin(now_ns);
    if (may_begin) share.note(piece_ns);
    sum_ns += may_begin ? piece_ns : 0;
    now_ns += may_begin ? piece_ns : 1'000'000;
  }
  return sum_ns;
}

TEST(WorkShare, WorksForItsShareAndABurstAtMost) {
  for (const std::int64_t piece_ns : {1'000, 2'000'000, 300'000'000}) {
    WorkShare share(0.25, 1'000'000'000);
    // A quarter of 20 s, and a burst of 1 s.
    const std::int64_t first_ns = work_for(share, 5'000'000, 20'000'000'000, piece_ns);
    EXPECT_LE(first_ns, 6'000'000'000 + piece_ns) << piece_ns;
    EXPECT_GE(first_ns, 5'700'000'000) << piece_ns;
    // A long rest allows one burst, no more.
    const std::int64_t later_ns = work_for(share, 900'000'000'000, 20'000'000'000, piece_ns);
    EXPECT_LE(later_ns, 6'000'000'000 + piece_ns) << piece_ns;
  }
}

TEST(WorkShare, WorkBelowItsShareNeverWaits) {
  WorkShare share(0.5, 100'000'000);
  for (std::int64_t now_ns = 1; now_ns < 10'000'000'000; now_ns += 10'000'000) {
    ASSERT_TRUE(share.may_begin(now_ns)) << now_ns;
    share.note(4'900'000);
  }
}

}  // namespace
}  // namespace hapton
