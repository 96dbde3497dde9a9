// A vision node undoes what the stylus carved: from its request to the list that every vision node gets.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <thread>

#include "core/geometry/mesh_shapes.h"
#include "haptics_node/reply_loop.h"
#include "tests/haptics_node/reply_loop_stage.h"

namespace hapton {
namespace {

constexpr std::uint32_t kUndoSource = 41;

TouchScene clay_to_undo() {
  return {.objects = {{.mesh = std::make_shared<const TriangleMesh>(make_icosphere(0.03, 3)),
                       .material = {.stiffness_n_per_m = 500.0},
                       .sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.004, .button = 1}}}};
}

class ReplyLoopUndo : public ReplyLoopStage {
 protected:
  ReplyLoopUndo() {
    loop_.set_carve_sender(&carves_);
    loop_.set_carve_undo(&task_);
    for (int i = 0; i < 10 && client_.state() != JoinState::joined; ++i) cycle(false);
  }
  void cycle(bool is_down) {
    ++sample_;
    const double angle = 3e-3 * static_cast<double>(sample_);
    const Vec3 p = (0.0315 + 0.004 * std::cos(5.0 * angle)) * Vec3(std::cos(angle), std::sin(angle), 0.1);
    send(DeviceState{.sample = sample_, .sample_time_ns = clock_.now_ns(), .p_WD = p, .buttons = is_down ? 1U : 0U});
    loop_.turn(clock_.now_ns() + kMs);
    receive_at_hub();
  }
  void take(const Message& message) override {
    if (const auto* got = std::get_if<ForceCommand>(&message)) carve_serial_ = got->carve_serial;
    const auto* got = std::get_if<Carves>(&message);
    for (std::uint32_t n = 0; got != nullptr && n < got->count; ++n) {
      const Carves::One& one = got->carves[n];
      list_.add({.object = one.object,
                 .serial = got->first + n,
                 .carve = {.radius_m = one.radius_m},
                 .begins = one.begins,
                 .undone = {one.undone_first, one.undone_last}});
    }
  }
  bool wait_for_undo_of(std::uint32_t serial) {
    for (int n = 0; n < 20'000 && list_.is_active(serial); ++n) {
      cycle(false);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return !list_.is_active(serial);
  }

  HapticsStep step_{std::make_unique<TouchStep>(*make_method({}, clay_to_undo()), clay_to_undo()), 1e-5};
  MethodBuilder builder_{{}, clay_to_undo()};
  CarveSender carves_{kUndoSource, 10'000};
  CarveUndoTask task_{*step_.touch().method().sculpture()};
  ReplyLoop loop_{client_, clock_, step_, builder_, {.scene_hash = 42}};
  CarveList list_;  // the carves that the hub has received
  std::uint32_t carve_serial_ = 0;
  std::uint64_t sample_ = 0;
};

TEST_F(ReplyLoopUndo, IsInTheListAndInTheForce) {
  for (int press = 0; press < 2; ++press) {
    for (int n = 0; n < 400; ++n) cycle(n < 250);
  }
  const std::uint32_t newest = list_.newest_active();
  ASSERT_GT(newest, 20U);
  ASSERT_EQ(carve_serial_, newest);
  const CarveRange press = list_.find_press(newest);
  ASSERT_GT(press.first, 1U) << "two presses";
  send(CarveUndo{.source = kUndoSource, .serial = newest});
  ASSERT_TRUE(wait_for_undo_of(newest));
  EXPECT_EQ(list_.newest_active(), press.first - 1);
  cycle(false);
  EXPECT_EQ(carve_serial_, newest + 1) << "the force says so";
  EXPECT_EQ(step_.touch().newest_carve_serial(), newest + 1);
  // The request is sent again, as a datagram may come twice: nothing more is undone.
  send(CarveUndo{.source = kUndoSource, .serial = newest});
  for (int n = 0; n < 60; ++n) {
    cycle(false);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(step_.touch().newest_carve_serial(), newest + 1);
}

TEST_F(ReplyLoopUndo, ForAnotherProcessIsLeftOut) {
  for (int n = 0; n < 300; ++n) cycle(true);
  const std::uint32_t newest = step_.touch().newest_carve_serial();
  ASSERT_GT(newest, 10U);
  send(CarveUndo{.source = kUndoSource + 2, .serial = 1});
  for (int n = 0; n < 60; ++n) {
    cycle(false);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(step_.touch().newest_carve_serial(), newest);
}

}  // namespace
}  // namespace hapton
