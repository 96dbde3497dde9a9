// What `hapton move` sends to a hub, and what it prints about the reply.
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tests/tools/command_run.h"
#include "tests/tools/replying_hub.h"

namespace hapton {
namespace {

// A hub with a haptics node that moves every object within half a second. It keeps the first request: one may come again.
struct MoveCommandTest : testing::Test {
  CommandRun move(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "move");
    arguments.insert(arguments.end(), {"--hub", hub.address(), "--key", hub.key_file()});
    CommandRun run = run_hapton(std::move(arguments));
    hub.end();
    return run;
  }

  std::optional<MoveRequest> first_request;
  ReplyingHub hub{[this](HubPeers& peers, std::size_t peer, const Message& message) {
    const auto* request = std::get_if<MoveRequest>(&message);
    if (request == nullptr) return true;
    if (!first_request) first_request = *request;
    peers.send_to(peer, MoveReply{.request = request->request, .over_s = 0.5});
    return true;
  }};
};

TEST_F(MoveCommandTest, PositionQuaternionAndTimeAreSentAsTheyAreGiven) {
  const CommandRun run = move({"lid", "--to", "0.1,-0.2,0.3", "--rotate", "0.1,0.5,-0.5,0.7", "--over", "0.5"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out, "lid moves, for 0.500 s\n");
  ASSERT_TRUE(first_request);
  EXPECT_STREQ(first_request->object.data(), "lid");
  ASSERT_TRUE(first_request->p_m);
  EXPECT_EQ(*first_request->p_m, Vec3(0.1, -0.2, 0.3));
  ASSERT_TRUE(first_request->q);
  EXPECT_LT((first_request->q->coeffs() - Quat(0.1, 0.5, -0.5, 0.7).coeffs()).norm(), 1e-12) << "w first";
  EXPECT_EQ(first_request->over_s, 0.5);
}

// A rotation in degrees, as in the scene file: a quarter turn about z alone.
TEST_F(MoveCommandTest, WhatIsLeftOutStaysAndASlowerMoveIsReported) {
  const CommandRun run = move({"#2", "--rotate", "0,0,90", "--over", "0.25"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out, "#2 moves, for 0.500 s, not 0.25 s: no point of it may be faster than 0.25 m/s\n");
  ASSERT_TRUE(first_request);
  EXPECT_EQ(first_request->object[0], '\0');
  EXPECT_EQ(first_request->number, 2);
  EXPECT_FALSE(first_request->p_m);
  ASSERT_TRUE(first_request->q);
  EXPECT_LT((*first_request->q * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-12);
}

TEST_F(MoveCommandTest, WithoutATimeItIsAsFastAsAllowed) {
  const CommandRun run = move({"lid", "--to", "0,0,0"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out, "lid moves, for 0.500 s\n") << "nothing was slowed down";
  ASSERT_TRUE(first_request);
  EXPECT_FALSE(first_request->over_s);
  EXPECT_FALSE(first_request->q);
}

}  // namespace
}  // namespace hapton
