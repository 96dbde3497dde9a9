#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "tests/faults/simulated_system.h"
#include "tests/support/time_units.h"

namespace hapton {

// A hand presses on the block, which it feels from patches, and picks it up. After that no force may come from where the block is not.
struct MovableTouch : testing::Test {
  static constexpr int kBlock = 1;
  static constexpr double kBlockTopM = 0.05;  // height of its top, where PressingDevice presses
  static constexpr double kBlockStiffness = 1000.0;
  static constexpr double kGridRoundingN = 1e-4;  // the rounding of vertices to a patch's grid, as a force
  static inline const Vec3 kPressed = Vec3(0.01, 0.02, kBlockTopM - 0.002);
  static inline const Vec3 kCarried = Vec3(0.03, 0.0, 0.005);
  static constexpr LinkFaults kFarLink{.delay_ns = 30 * kMs};

  static Scene block_over_plate() {
    const auto object = [](const char* name, const Vec3& low, const Vec3& high) {
      SceneObject box;
      box.name = name;
      box.mesh = made::shared(made::box(low, high));
      box.material.stiffness_n_per_m = kBlockStiffness;
      return box;
    };
    Scene scene;
    scene.objects = {object("plate", Vec3(-0.06, -0.06, -0.05), Vec3(0.06, 0.06, 0.0)),
                     object("block", Vec3(0.0, 0.01, 0.001), Vec3(0.02, 0.03, kBlockTopM))};
    scene.objects[kBlock].is_movable = true;
    return scene;
  }

  std::optional<SimulatedSystem> system;
  Vec3 displacement_m = Vec3::Zero();  // displacement of the block from its place in the scene
  std::size_t checked_count = 0;       // number of entries of system->local_steps that were checked
  bool builds_on_approach = false;
  std::function<void(Scene&)> change_scene = {};  // changes the scene before it is loaded, but not the block

  void press(std::uint64_t seed, const LinkFaults& faults, TouchChoice choice = TouchChoice::patch) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    system.emplace(seed, choice);
    system->scene = block_over_plate();
    if (change_scene) change_scene(system->scene);
    system->builds_on_approach = builds_on_approach;
    system->start_haptics();
    // Waits for a force command while the hand is above: a hand that begins inside the block has no contact.
    for (int n = 0; builds_on_approach && n < 80 && system->stats().forces == 0; ++n) {
      system->run_for_ns(kMs);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    system->run_for_ns(500 * kMs);
    if (choice == TouchChoice::patch) {
      ASSERT_TRUE(system->wait_for_patches());
    }
    system->set_faults(faults, faults);
    system->run_for_ns(500 * kMs);
    system->device.target = kPressed;
    system->run_for_ns(500 * kMs);
    if (choice != TouchChoice::remote) {
      ASSERT_TRUE(system->wait_for_patches());
    }
    system->run_for_ns(300 * kMs);
    ASSERT_TRUE(expect_block());
  }
  const Grasp& grasp() const { return system->haptics->grasp(); }

  // Expects that the hub's forces from patches since the last call are those of the block where it is now, and of nothing else.
  bool expect_block() {
    for (; checked_count < system->local_steps.size(); ++checked_count) {
      const auto& [sample, force, is_beyond] = system->local_steps[checked_count];
      if (is_beyond) continue;
      const Vec3 p = sample.p_WD - displacement_m;
      const bool is_over = p.x() > 0.0005 && p.x() < 0.0195 && p.y() > 0.0105 && p.y() < 0.0295;
      const bool is_beside = p.x() < -0.0005 || p.x() > 0.0205 || p.y() < 0.0095 || p.y() > 0.0305;
      if (!is_over && !is_beside) continue;
      const double depth_m = is_over ? std::max(0.0, kBlockTopM - p.z()) : 0.0;
      EXPECT_NEAR(force.force_n.z(), kBlockStiffness * depth_m, kGridRoundingN) << checked_count << ": " << sample.p_WD.transpose();
      const bool is_certain = !is_over || std::abs(kBlockTopM - p.z()) > kGridRoundingN / kBlockStiffness;
      EXPECT_TRUE(!is_certain || force.contact == (depth_m > 0.0)) << checked_count << ": " << sample.p_WD.transpose();
      if (testing::Test::HasFailure()) return false;
    }
    return true;
  }
  void pick_up() {
    system->device.buttons = 1;
    ASSERT_TRUE(system->wait_until([&] { return grasp().tool() != nullptr; }));
    ASSERT_TRUE(expect_block()) << "where it was until it is picked up";
  }
  // No force comes from patches as long as the block is held.
  void carry(const Vec3& to) {
    const Vec3 from = std::exchange(system->device.target, to).value_or(to);
    // Runs slowly enough for the task that moves the object, which runs in real time.
    system->run_slowly_for_ns(static_cast<std::int64_t>(2e10 * (to - from).norm()) + 500 * kMs);
    EXPECT_EQ(system->local_steps.size(), checked_count);
  }
  void put_down() {
    system->device.buttons = 0;
    ASSERT_TRUE(system->wait_until([&] { return !grasp().is_busy(); }));
    EXPECT_EQ(system->local_steps.size(), checked_count) << "before it can be touched where it was put down";
    displacement_m = grasp().poses()[kBlock].p_m;
    ASSERT_TRUE(system->wait_for_patches());
    ASSERT_TRUE(expect_block());
  }
  void lead(const Vec3& to) {
    system->device.target = to;
    for (int n = 0; n < 30; ++n) {
      system->run_for_ns(100 * kMs);
      ASSERT_TRUE(expect_block());
    }
  }
  // The hand moves into the place where the block was, and then onto the block.
  void feel_both_places() {
    lead(kPressed + displacement_m + Vec3(0, 0, 0.02));
    lead(kPressed + Vec3(-0.005, 0, 0.03));
    ASSERT_TRUE(system->wait_for_patches());
    lead(kPressed + Vec3(-0.005, 0, -0.01));
    EXPECT_FALSE(system->local_steps.back().force.contact)
        << "object " << system->local_steps.back().force.object << " with " << system->local_steps.back().force.force_n.transpose()
        << " N; moved by " << displacement_m.transpose();
    EXPECT_NEAR((system->local_steps.back().sample.p_WD - *system->device.target).norm(), 0.0, 1e-9);
    lead(kPressed + Vec3(-0.005, 0, 0.03));
    lead(kPressed + displacement_m + Vec3(0, 0, 0.02));
    lead(kPressed + displacement_m);
    ASSERT_TRUE(system->wait_for_patches());
    ASSERT_TRUE(expect_block());
    EXPECT_TRUE(system->local_steps.back().force.contact);
    EXPECT_EQ(system->local_steps.back().force.object, kBlock);
  }
};

}  // namespace hapton
