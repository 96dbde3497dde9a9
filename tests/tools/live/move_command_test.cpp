// What `hapton move` sends to a hub, and what it says of the reply.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "link/hub_peers.h"
#include "link/link_key.h"
#include "link/random_id.h"
#include "link/sealed_hub.h"
#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "tests/support/scratch_folder.h"
#include "tests/tools/command_run.h"

namespace hapton {
namespace {

// A hub with a haptics node that moves every object within half a second. It keeps the first request: one may come again.
class MovingHub {
 public:
  explicit MovingHub(const LinkKey& key) : key_(key), thread_([this] { run(); }) {}
  ~MovingHub() { end(); }
  std::string address() const { return to_string(endpoint_->local_address()); }
  // What came is complete and can be read from now on.
  void end() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }

  std::optional<MoveRequest> move;

 private:
  void run() {
    SealedHub sealed(*endpoint_, clock_, key_);
    HubPeers peers(sealed, clock_, make_random_id(), 1000.0);
    Datagram datagram;
    while (!ends_) {
      const PeerEvent event = peers.receive(datagram, clock_.now_ns() + kNanosecondsPerMillisecond);
      const auto* request = std::get_if<MoveRequest>(&datagram.message);
      if (event.kind != PeerEvent::Kind::message || request == nullptr) continue;
      if (!move) move = *request;
      peers.send_to(event.peer, MoveReply{.request = request->request, .over_s = 0.5});
    }
  }

  LinkKey key_;
  SteadyClock clock_;
  std::unique_ptr<Endpoint> endpoint_ = *open_udp_endpoint("127.0.0.1:0");
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

struct MoveCommandTest : testing::Test {
  void SetUp() override {
    ASSERT_TRUE(make_key_file(key_file));
    hub = std::make_unique<MovingHub>(*read_key_file(key_file));
  }
  CommandRun move(std::vector<std::string> words) {
    words.insert(words.begin(), "move");
    words.insert(words.end(), {"--hub", hub->address(), "--key", key_file});
    CommandRun run = run_hapton(std::move(words));
    hub->end();
    return run;
  }

  ScratchFolder folder;
  std::string key_file = (folder.path() / "key").string();
  std::unique_ptr<MovingHub> hub;
};

TEST_F(MoveCommandTest, PositionQuaternionAndTimeAreSentAsTheyAreGiven) {
  const CommandRun run = move({"lid", "--to", "0.1,-0.2,0.3", "--rotate", "0.1,0.5,-0.5,0.7", "--over", "0.5"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out, "lid moves, for 0.500 s\n");
  ASSERT_TRUE(hub->move);
  EXPECT_STREQ(hub->move->object.data(), "lid");
  ASSERT_TRUE(hub->move->p_m);
  EXPECT_EQ(*hub->move->p_m, Vec3(0.1, -0.2, 0.3));
  ASSERT_TRUE(hub->move->q);
  EXPECT_LT((hub->move->q->coeffs() - Quat(0.1, 0.5, -0.5, 0.7).coeffs()).norm(), 1e-12) << "w first";
  EXPECT_EQ(hub->move->over_s, 0.5);
}

// A rotation in degrees, as in the scene file: a quarter turn about z alone.
TEST_F(MoveCommandTest, WhatIsLeftOutStaysAndASlowerMoveIsSaid) {
  const CommandRun run = move({"#2", "--rotate", "0,0,90", "--over", "0.25"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out, "#2 moves, for 0.500 s, not 0.25 s: no point of it may be faster than 0.25 m/s\n");
  ASSERT_TRUE(hub->move);
  EXPECT_EQ(hub->move->object[0], '\0');
  EXPECT_EQ(hub->move->number, 2);
  EXPECT_FALSE(hub->move->p_m);
  ASSERT_TRUE(hub->move->q);
  EXPECT_LT((*hub->move->q * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-12);
}

TEST_F(MoveCommandTest, WithoutATimeItIsAsFastAsAllowed) {
  const CommandRun run = move({"lid", "--to", "0,0,0"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out, "lid moves, for 0.500 s\n") << "nothing was slowed down";
  ASSERT_TRUE(hub->move);
  EXPECT_FALSE(hub->move->over_s);
  EXPECT_FALSE(hub->move->q);
}

}  // namespace
}  // namespace hapton
