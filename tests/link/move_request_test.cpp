#include "link/move_request.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "link/commanded_move.h"

namespace hapton {
namespace {

TEST(MoveRequests, HoldWhatWasGivenAndANumber) {
  const MoveTarget target{.position_m = Vec3(0.1, 0.2, 0.3), .rotation = Quat(0.6, 0.8, 0, 0), .over_s = 2.5};
  const auto request = make_move_request("front hood", target);
  ASSERT_TRUE(request);
  EXPECT_STREQ(request->object.data(), "front hood");
  EXPECT_EQ(request->p_m, target.position_m);
  EXPECT_EQ(request->q->coeffs(), target.rotation->coeffs());
  EXPECT_EQ(request->over_s, 2.5);
  EXPECT_NE(request->request, 0U);
  EXPECT_NE(make_move_request("front hood", target)->request, request->request);
  const auto numbered = make_move_request("#12", {.position_m = Vec3::Zero()});
  ASSERT_TRUE(numbered);
  EXPECT_EQ(numbered->object[0], '\0');
  EXPECT_EQ(numbered->number, 12);
  EXPECT_FALSE(numbered->q || numbered->over_s);
}

TEST(MoveRequests, WhatNoRequestMayHaveIsOneLine) {
  const MoveTarget good{.position_m = Vec3::Zero()};
  const auto rejected = [](const std::string& object, const MoveTarget& target) {
    const auto made = make_move_request(object, target);
    EXPECT_FALSE(made) << object;
    EXPECT_TRUE(made || made.error().what.find('\n') == std::string::npos);
  };
  for (const std::string& object : {std::string(), std::string("#"), std::string("#-1"), std::string("#1x"), std::string("#99999999999"),
                                    std::string("a\nb"), std::string(256, 'x')}) {
    rejected(object, good);
  }
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  rejected("lid", {});
  rejected("lid", {.position_m = Vec3(0, kNan, 0)});
  rejected("lid", {.position_m = Vec3(0, 2e9, 0)});
  rejected("lid", {.rotation = Quat(1, 1, 0, 0)});
  rejected("lid", {.rotation = Quat(kNan, 0, 0, 0)});
  for (const double seconds : {0.0, -1.0, kNan, 86'401.0}) rejected("lid", {.position_m = Vec3::Zero(), .over_s = seconds});
}

TEST(MoveRequests, AReplyIsATimeOrAReason) {
  EXPECT_EQ(*read_reply(MoveReply{.request = 1, .over_s = 0.75}), 0.75);
  const auto rejected = read_reply(MoveReply{.request = 1, .rejection = {"no such object"}});
  ASSERT_FALSE(rejected);
  EXPECT_NE(rejected.error().what.find("no such object"), std::string::npos);
}

TEST(MoveRequests, AMoveOfTheWireIsInSecondsOfSceneTime) {
  const ObjectMove sent{.source = 1,
                        .serial = 9,
                        .object = 2,
                        .start_ns = 1'500'000'000,
                        .end_ns = 4'000'000'000,
                        .from_p_m = Vec3(1, 2, 3),
                        .from_q = Quat(0.6, 0.8, 0, 0),
                        .to_p_m = Vec3(4, 5, 6),
                        .to_q = Quat(0, 0, 1, 0)};
  const CommandedMove move = to_command(sent);
  EXPECT_EQ(move.serial, 9U);
  EXPECT_EQ(move.from, (Keyframe{1.5, Vec3(1, 2, 3), Quat(0.6, 0.8, 0, 0)}));
  EXPECT_EQ(move.to, (Keyframe{4.0, Vec3(4, 5, 6), Quat(0, 0, 1, 0)}));
}

}  // namespace
}  // namespace hapton
