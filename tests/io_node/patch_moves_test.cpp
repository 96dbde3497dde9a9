#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "io_node/patch_link.h"
#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

// A network loop that works with patches.
struct PatchMoves : NetworkLoops {
  LocalPatch local;
  PatchThread thread{local};
  std::unique_ptr<PatchLink> link;

  void start() {
    link = std::make_unique<PatchLink>(peers, local, thread, TouchChoice::patch);
    make();
    network->set_patch_link(link.get());
    join(kHaptics, NodeRole::haptics);
    run(100);
  }
};

// The haptics node repeats a move until the hub has confirmed its serial.
TEST_F(PatchMoves, MovesOfObjectsAreConfirmedSoon) {
  start();
  run(200);
  ASSERT_EQ(patch_statuses.back().second.newest_move, 0U);
  ObjectMove move;
  move.source = 5;
  move.serial = 3;
  move.object = 2;
  move.end_ns = kMs;
  move.to_p_m = Vec3(0.1, 0, 0);
  const std::int64_t sent_ns = clock.now_ns();
  say(kHaptics, move);
  run(55);
  const auto confirmed =
      std::find_if(patch_statuses.begin(), patch_statuses.end(), [](const auto& s) { return s.second.newest_move == 3U; });
  ASSERT_NE(confirmed, patch_statuses.end());
  EXPECT_LE(confirmed->first - sent_ns, PatchLink::kMinStatusNs + 2 * kMs);
  const std::size_t statuses_before = patch_statuses.size();
  say(kHaptics, move);
  run(60);
  EXPECT_LE(patch_statuses.size(), statuses_before + 1) << "a repeated move is no news";
  endpoint.arrive(clock.now_ns(), at(kHaptics), {{kSession, 5000, 1, clock.now_ns()}, Hello{NodeRole::haptics}});  // another process
  for (int n = 0; n < 110; ++n) network->step();
  EXPECT_EQ(patch_statuses.back().second.newest_move, 0U) << "another haptics node has moved nothing yet";
}

}  // namespace
}  // namespace hapton
