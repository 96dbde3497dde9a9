#include "link/shape_outbox.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "link/hub_peers.h"
#include "link/memory_endpoint.h"
#include "link/shape_parts.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

using Displacements = std::vector<ShapePart::Displacement>;

class ShapeOutboxTest : public testing::Test {
 protected:
  ShapeOutboxTest() {
    for (int n = 0; n < 50 && client_.state() != JoinState::joined; ++n) turn();
  }
  // Lets 1 ms pass: the outbox sends the parts that are due, and the hub receives them.
  void turn() {
    Datagram datagram;
    outbox_.send(client_, clock_.now_ns());
    while (client_.receive(datagram, clock_.now_ns())) outbox_.take(datagram.message);
    const std::int64_t end_ns = clock_.now_ns() + kMs;
    while (clock_.now_ns() < end_ns) {
      if (hub_.receive(datagram, end_ns).kind != PeerEvent::Kind::message) continue;
      if (const auto* part = std::get_if<ShapeRequest>(&datagram.message)) parts_.push_back(*part);
    }
  }
  void reply(ShapeReply reply) {
    hub_.send_to_role(NodeRole::tool, reply);
    turn();
    turn();
  }

  SimulatedClock clock_;
  MemoryNetwork network_{clock_};
  std::unique_ptr<Endpoint> hub_endpoint_ = *network_.open(memory_address(1, 4950));
  std::unique_ptr<Endpoint> endpoint_ = *network_.open(memory_address(2, 0));
  HubPeers hub_{*hub_endpoint_, clock_, 1, 1000.0};
  HubClient client_{*endpoint_, clock_, NodeRole::tool, memory_address(1, 4950)};
  ShapeOutbox outbox_;
  std::vector<ShapeRequest> parts_;
};

TEST_F(ShapeOutboxTest, SendsAShapeInPartsAFewAtATime) {
  Displacements shape(1000);
  for (std::size_t v = 0; v < shape.size(); ++v) shape[v] = {static_cast<float>(v), 0, 0};
  const auto number = outbox_.give("skin", shape, 0.03);
  ASSERT_TRUE(number);
  turn();
  EXPECT_EQ(parts_.size(), ShapeOutbox::kPartsAtOnce);
  for (int n = 0; n < 10; ++n) turn();
  ASSERT_EQ(parts_.size(), 16U) << "1000 vertices in parts of 64, each once";
  ShapeParts whole(1000);
  for (const ShapeRequest& part : parts_) {
    EXPECT_STREQ(part.object.data(), "skin");
    EXPECT_EQ(part.shape, *number);
    EXPECT_EQ(part.stream, parts_[0].stream);
    EXPECT_EQ(part.over_s, 0.03);
    whole.add(part.part);
  }
  ASSERT_TRUE(whole.is_whole());
  EXPECT_TRUE(std::equal(shape.begin(), shape.end(), whole.displacements_m().begin()));
  EXPECT_TRUE(outbox_.is_empty());
}

TEST_F(ShapeOutboxTest, OnlyTheNewestWaitingShapeOfAnObjectIsSent) {
  const Displacements shape(640);  // ten parts
  ASSERT_TRUE(outbox_.give("skin", shape, 0.0));
  turn();  // the first shape has begun
  for (int n = 0; n < 5; ++n) ASSERT_TRUE(outbox_.give("skin", shape, 0.0));
  ASSERT_TRUE(outbox_.give("#3", shape, 0.0)) << "another object";
  for (int n = 0; n < 20; ++n) turn();
  ASSERT_EQ(parts_.size(), 30U);
  EXPECT_EQ(parts_[9].shape, 1U);
  EXPECT_EQ(parts_[10].shape, 6U);
  EXPECT_EQ(parts_[20].shape, 7U);
  EXPECT_EQ(parts_[20].number, 3);
}

TEST_F(ShapeOutboxTest, WhatIsNeededIsSentUntilItsReplyComes) {
  const auto number = outbox_.give("skin", Displacements(100), 0.0, true);
  ASSERT_TRUE(number);
  for (int n = 0; n < 1000; ++n) turn();
  EXPECT_GE(parts_.size(), 6U);
  EXPECT_LE(parts_.size(), 8U);
  EXPECT_FALSE(outbox_.is_empty());
  reply({.stream = parts_[0].stream + 2, .shape = *number, .over_s = 9.0});
  EXPECT_FALSE(outbox_.find_reply(*number)) << "to another program";
  reply({.stream = parts_[0].stream, .shape = *number, .over_s = 0.125});
  EXPECT_TRUE(outbox_.is_empty());
  EXPECT_EQ(*outbox_.wait_for(*number, 0.0), 0.125);
  const auto other = outbox_.wait_for(*number + 1, 0.0);
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().what.find("no reply"), std::string::npos);
}

TEST_F(ShapeOutboxTest, AShapeThatANewerOneReplacesIsSentToItsEndButNotAgain) {
  const Displacements shape(640);  // ten parts
  ASSERT_TRUE(outbox_.give("skin", shape, 0.0, true));
  turn();  // the first shape has begun
  const auto newer = outbox_.give("skin", shape, 0.0);
  ASSERT_TRUE(newer);
  for (int n = 0; n < 1000; ++n) turn();
  ASSERT_EQ(parts_.size(), 20U);
  EXPECT_EQ(parts_[9].shape + 1, *newer);
  EXPECT_EQ(parts_[10].shape, *newer);
  EXPECT_TRUE(outbox_.is_empty()) << "no reply is awaited";
}

TEST_F(ShapeOutboxTest, ARejectionIsTheError) {
  const auto number = outbox_.give("skin", Displacements(100), 0.0, true);
  for (int n = 0; n < 5; ++n) turn();
  ASSERT_FALSE(parts_.empty());
  reply({.stream = parts_[0].stream, .shape = *number, .rejection = {"out of reach"}});
  const auto duration_s = outbox_.wait_for(*number, 0.0);
  ASSERT_FALSE(duration_s);
  EXPECT_NE(duration_s.error().what.find("out of reach"), std::string::npos);
}

TEST_F(ShapeOutboxTest, WithoutAReplyTheErrorSaysHowLongItWaited) {
  const auto duration_s = deform_object(client_, clock_, outbox_, "skin", Displacements(100), 0.0, 0.5);
  ASSERT_FALSE(duration_s);
  EXPECT_NE(duration_s.error().what.find("within 0.5 s"), std::string::npos) << duration_s.error().what;
  EXPECT_TRUE(outbox_.is_empty()) << "and it is not sent any more";
}

// Another thread may take the reply after the time to wait has ended, but before the waiting thread gives up.
TEST_F(ShapeOutboxTest, AReplyAtTheLastMomentCounts) {
  const auto number = outbox_.give("skin", Displacements(100), 0.0, true);
  for (int n = 0; n < 5; ++n) turn();
  ASSERT_FALSE(parts_.empty());
  outbox_.take(ShapeReply{.stream = parts_[0].stream, .shape = *number, .over_s = 0.25});
  const auto duration_s = outbox_.give_up(*number, 0.5);
  ASSERT_TRUE(duration_s) << duration_s.error().what;
  EXPECT_EQ(*duration_s, 0.25);
}

TEST_F(ShapeOutboxTest, WhatNoShapeMayHaveIsOneLine) {
  const auto expect_rejected = [&](const std::string& object, const Displacements& shape, double over_s) {
    const auto number = outbox_.give(object, shape, over_s);
    ASSERT_FALSE(number) << object;
    EXPECT_EQ(number.error().what.find('\n'), std::string::npos);
  };
  const Displacements good(10);
  for (const std::string& object :
       {std::string(), std::string("#"), std::string("#-1"), std::string("#1x"), std::string("a\nb"), std::string(256, 'x')}) {
    expect_rejected(object, good, 0.0);
  }
  expect_rejected("skin", {}, 0.0);
  expect_rejected("skin", Displacements(ShapePart::kMaxVertices + 1), 0.0);
  for (const double over_s : {-1.0, 86'401.0, std::numeric_limits<double>::quiet_NaN()}) expect_rejected("skin", good, over_s);
  for (const float x : {std::numeric_limits<float>::quiet_NaN(), 2e9F}) {
    Displacements bad = good;
    bad[9][2] = x;
    expect_rejected("skin", bad, 0.0);
  }
  EXPECT_TRUE(outbox_.is_empty());
}

TEST_F(ShapeOutboxTest, KeepsTheNewestReplyToEachOfTheLastShapes) {
  const auto number = outbox_.give("skin", Displacements(100), 0.0, true);
  for (int n = 0; n < 5; ++n) turn();
  ASSERT_FALSE(parts_.empty());
  const auto take = [&](std::uint32_t shape, double over_s) {
    outbox_.take(ShapeReply{.stream = parts_[0].stream, .shape = shape, .over_s = over_s});
  };
  take(*number, 0.0);
  for (int n = 0; n < 1000; ++n) take(*number + 1, 0.001 * n);  // the node repeats a reply that may have been lost
  EXPECT_EQ(outbox_.find_reply(*number + 1)->over_s, 0.999);
  EXPECT_TRUE(outbox_.find_reply(*number)) << "a repeated reply takes no other's place";
  for (std::uint32_t n = 0; n < 10'000; ++n) take(*number + 100 + n, 0.0);
  EXPECT_FALSE(outbox_.find_reply(*number)) << "of a program that runs for days, only the last ones are kept";
  EXPECT_TRUE(outbox_.find_reply(*number + 100 + 9'999));
}

}  // namespace
}  // namespace hapton
