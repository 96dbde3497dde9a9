#include "io_node/stranger_news.h"

#include <gtest/gtest.h>

#include <vector>

namespace hapton {
namespace {

using Kinds = std::vector<ServoEvent::Kind>;

Kinds look(StrangerNews& news, const SealCounts& seal, const HubCounts& hub, std::int64_t now_ns) {
  Kinds told;
  news.look(seal, hub, now_ns, [&](ServoEvent::Kind kind) { told.push_back(kind); });
  return told;
}

TEST(StrangerNewsTest, TellsOfEachKindThatCame) {
  StrangerNews news;
  EXPECT_TRUE(look(news, {}, {}, 0).empty());
  EXPECT_EQ(look(news, {.wrong_version = 3, .wrong_key = 1}, {.role_violations = 2}, 1),
            (Kinds{ServoEvent::Kind::wrong_key, ServoEvent::Kind::wrong_version, ServoEvent::Kind::role_violation}));
}

TEST(StrangerNewsTest, TellsEveryTenSecondsAtMostAndNothingTwice) {
  StrangerNews news;
  EXPECT_EQ(look(news, {.wrong_key = 1}, {}, 0), Kinds{ServoEvent::Kind::wrong_key});
  EXPECT_TRUE(look(news, {.wrong_key = 9}, {.role_violations = 1}, StrangerNews::kEveryNs - 1).empty());
  EXPECT_EQ(look(news, {.wrong_key = 9}, {.role_violations = 1}, StrangerNews::kEveryNs),
            (Kinds{ServoEvent::Kind::wrong_key, ServoEvent::Kind::role_violation}));
  EXPECT_TRUE(look(news, {.wrong_key = 9}, {.role_violations = 1}, 3 * StrangerNews::kEveryNs).empty());
}

TEST(RefusalNewsTest, OfANodeThatKeepsTryingIsOneUntilItPauses) {
  RefusalNews news;
  EXPECT_TRUE(news.is_news(NodeRole::haptics, 0));
  std::int64_t now_ns = 0;
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(news.is_news(NodeRole::haptics, now_ns += 100 * kNanosecondsPerMillisecond));
  EXPECT_TRUE(news.is_news(NodeRole::vision, now_ns)) << "another role's is news of its own";
  EXPECT_TRUE(news.is_news(NodeRole::haptics, now_ns + RefusalNews::kPauseNs + 1));
}

}  // namespace
}  // namespace hapton
