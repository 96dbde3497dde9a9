#include "link/move_request.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <limits>
#include <string>
#include <vector>

#include "link/codec.h"
#include "link/commanded_move.h"
#include "tests/support/time_units.h"

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
  const auto expect_rejected = [](const std::string& object, const MoveTarget& target) {
    const auto made = make_move_request(object, target);
    EXPECT_FALSE(made) << object;
    EXPECT_TRUE(made || made.error().what.find('\n') == std::string::npos);
  };
  for (const std::string& object : {std::string(), std::string("#"), std::string("#-1"), std::string("#1x"), std::string("#99999999999"),
                                    std::string("a\nb"), std::string(256, 'x')}) {
    expect_rejected(object, good);
  }
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  expect_rejected("lid", {});
  expect_rejected("lid", {.position_m = Vec3(0, kNan, 0)});
  expect_rejected("lid", {.position_m = Vec3(0, 2e9, 0)});
  expect_rejected("lid", {.rotation = Quat(1, 1, 0, 0)});
  expect_rejected("lid", {.rotation = Quat(kNan, 0, 0, 0)});
  for (const double seconds : {0.0, -1.0, kNan, 86'401.0}) expect_rejected("lid", {.position_m = Vec3::Zero(), .over_s = seconds});
}

TEST(MoveRequests, AReplyIsATimeOrAReason) {
  EXPECT_EQ(*read_reply(MoveReply{.request = 1, .over_s = 0.75}), 0.75);
  const auto rejected = read_reply(MoveReply{.request = 1, .rejection = {"no such object"}});
  ASSERT_FALSE(rejected);
  EXPECT_NE(rejected.error().what.find("no such object"), std::string::npos);
}

TEST(MoveRequests, AMoveFromTheWireIsConvertedToSecondsOfSceneTime) {
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

// A hub whose haptics node replies to a request to move when the request has come `replies_after` times.
class MovingHub final : public Endpoint {
 public:
  explicit MovingHub(SimulatedClock& clock) : clock_(clock) {}

  bool send(const Address&, std::span<const std::byte> bytes) noexcept override {
    Datagram datagram;
    EXPECT_EQ(codec_.decode(bytes, datagram), DecodeStatus::ok);
    if (std::holds_alternative<Hello>(datagram.message)) queue(Welcome{true, 1000.0});
    if (const auto* request = std::get_if<MoveRequest>(&datagram.message)) {
      requests.push_back(request->request);
      if (requests.size() != replies_after) return true;
      queue(MoveReply{.request = request->request + 2, .over_s = 9.0});  // to somebody else
      reply.request = request->request;
      queue(reply);
    }
    return true;
  }
  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override {
    if (queued_.empty()) {
      clock_.sleep_until_ns(deadline_ns);
      return {};
    }
    const std::vector<std::byte> next = queued_.front();
    queued_.pop_front();
    std::copy(next.begin(), next.end(), into.begin());
    return {.bytes = next.size(), .from = local_address()};
  }
  Address local_address() const override { return {{9}, 1}; }

  std::size_t replies_after = 1;
  MoveReply reply;
  std::vector<std::uint32_t> requests;

 private:
  void queue(const Message& message) {
    std::array<std::byte, kMaxDatagramBytes> bytes;
    const std::size_t size = codec_.encode({{7, 8, ++sequence_, clock_.now_ns()}, message}, bytes);
    queued_.emplace_back(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
  }

  SimulatedClock& clock_;
  Codec codec_;
  std::uint64_t sequence_ = 0;
  std::deque<std::vector<std::byte>> queued_;
};

struct MovesOfObjects : testing::Test {
  SimulatedClock clock{kMs};
  MovingHub hub{clock};
  HubClient client{hub, clock, NodeRole::tool, hub.local_address()};
  MoveRequest request = *make_move_request("lid", {.position_m = Vec3(0.1, 0.2, 0.3)});
};

// A datagram may be lost, so the request is repeated.
TEST_F(MovesOfObjects, AreRequestedUntilTheReplyComes) {
  hub.replies_after = 3;
  hub.reply.over_s = 0.75;
  const auto moved = move_object(client, clock, request, 5.0);
  ASSERT_TRUE(moved) << moved.error().what;
  EXPECT_EQ(*moved, 0.75) << "of its own request, not of another's";
  EXPECT_EQ(hub.requests, std::vector<std::uint32_t>(3, request.request));
}

TEST_F(MovesOfObjects, AreOneLineWhereTheyAreRejectedOrNobodyReplies) {
  hub.reply.rejection = {"no object has that name"};
  EXPECT_EQ(move_object(client, clock, request, 5.0).error().what, "the haptics node rejected it: no object has that name");
  hub.replies_after = 0;
  hub.requests.clear();
  const std::int64_t begin_ns = clock.now_ns();
  EXPECT_EQ(move_object(client, clock, request, 0.5).error().what,
            "no haptics node replied within 0.5 s; start haptics_node, or update it to this version");
  EXPECT_EQ(clock.now_ns(), begin_ns + 500 * kMs);
  EXPECT_EQ(hub.requests.size(), 5U) << "ten times a second";
}

}  // namespace
}  // namespace hapton
