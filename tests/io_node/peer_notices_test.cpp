#include "io_node/peer_notices.h"

#include <gtest/gtest.h>

#include <vector>

namespace hapton {
namespace {

using Kinds = std::vector<ServoEvent::Kind>;

Kinds check(UnknownPeerNotices& notices, const SealCounts& seal, const HubCounts& hub, std::int64_t now_ns) {
  Kinds reported;
  notices.check(seal, hub, now_ns, [&](ServoEvent::Kind kind) { reported.push_back(kind); });
  return reported;
}

TEST(UnknownPeerNoticesTest, ReportsEachKind) {
  UnknownPeerNotices notices;
  EXPECT_TRUE(check(notices, {}, {}, 0).empty());
  EXPECT_EQ(check(notices, {.wrong_version = 3, .wrong_key = 1}, {.role_violations = 2}, 1),
            (Kinds{ServoEvent::Kind::wrong_key, ServoEvent::Kind::wrong_version, ServoEvent::Kind::role_violation}));
}

TEST(UnknownPeerNoticesTest, ReportsAtMostEveryTenSecondsAndNothingTwice) {
  UnknownPeerNotices notices;
  EXPECT_EQ(check(notices, {.wrong_key = 1}, {}, 0), Kinds{ServoEvent::Kind::wrong_key});
  EXPECT_TRUE(check(notices, {.wrong_key = 9}, {.role_violations = 1}, UnknownPeerNotices::kEveryNs - 1).empty());
  EXPECT_EQ(check(notices, {.wrong_key = 9}, {.role_violations = 1}, UnknownPeerNotices::kEveryNs),
            (Kinds{ServoEvent::Kind::wrong_key, ServoEvent::Kind::role_violation}));
  EXPECT_TRUE(check(notices, {.wrong_key = 9}, {.role_violations = 1}, 3 * UnknownPeerNotices::kEveryNs).empty());
}

TEST(RejectionNoticesTest, OfANodeThatKeepsTryingIsOneUntilItPauses) {
  RejectionNotices notices;
  EXPECT_TRUE(notices.is_due(NodeRole::haptics, 0));
  std::int64_t now_ns = 0;
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(notices.is_due(NodeRole::haptics, now_ns += 100 * kNanosecondsPerMillisecond));
  EXPECT_TRUE(notices.is_due(NodeRole::vision, now_ns)) << "another role has notices of its own";
  EXPECT_TRUE(notices.is_due(NodeRole::haptics, now_ns + RejectionNotices::kPauseNs + 1));
}

}  // namespace
}  // namespace hapton
