#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "haptic_step/haptics_setup.h"
#include "haptic_step/material_tuning.h"
#include "haptic_step/method_text.h"
#include "tests/support/made_meshes.h"
#include "tools/session/session_replay.h"

namespace hapton {

constexpr std::uint64_t kSender = 9;  // the haptics node that replied

inline TouchScene one_sphere() {
  return {.objects = {{made::shared(made::sphere(0.05, 16)), {.friction_static = 0.4, .friction_dynamic = 0.3}}}};
}

inline std::unique_ptr<TouchStep> make_sphere_touch(const char* method) {
  return std::make_unique<TouchStep>(*make_method({.name = method}, one_sphere()));
}

// A motion that shifts and turns the object and brings it back within 0.2 s, repeated.
inline std::shared_ptr<const KeyframeMotion> make_turn_to_and_fro() {
  const Quat turned(Eigen::AngleAxisd(0.5, Vec3(1, 2, 3).normalized()));
  return std::make_shared<const KeyframeMotion>(
      Vec3(0.001, 0, 0),
      std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {0.1, Vec3(0.005, 0, 0), turned}, {0.2, Vec3::Zero(), Quat::Identity()}},
      true);
}

// A running haptics step, whose states and replies are kept as a recording.
struct SessionReplayTest : testing::Test {
  HapticsStep live;
  HapticsSetups setups;
  MaterialStates materials;
  std::uint64_t sample = 0;
  std::vector<std::pair<DeviceState, std::optional<ForceCommand>>> recorded;

  explicit SessionReplayTest(std::unique_ptr<TouchStep> touch = make_sphere_touch("proxy"))
      : live(std::move(touch), MethodSettings().offset_m) {
    send_setup("proxy");
  }

  void send_setup(const char* method) {
    const auto serial = static_cast<std::uint32_t>(live.counts().method_changes);
    HapticsSetup setup;
    setup.method_serial = serial;
    setup.view_revision = live.view().revision;
    setup.X_WS = live.view().X_WS;
    put_text(to_text({.name = method}), setup.method);
    setup.material_serial = static_cast<std::uint32_t>(live.counts().materials_taken);
    setups[{kSender, serial}] = setup;
  }

  // Changes the material while the sphere is touched, and keeps the MaterialState that a node would send.
  std::vector<Material> tune(const MaterialChange& change) {
    MaterialState state{.serial = static_cast<std::uint32_t>(live.counts().materials_taken) + 1, .object_count = 1};
    state.objects[0] = {-1, change};
    materials[{kSender, state.serial}] = state;
    auto tuned = tuned_materials(one_sphere(), state, 0.0);
    live.set_materials(tuned);
    return tuned;
  }

  // The next state on a slide over the sphere.
  DeviceState next_state() {
    ++sample;
    const double angle = 2e-3 * static_cast<double>(sample);
    const double radius = sample < 20 ? 0.06 : 0.049;
    return {.sample = sample,
            .sample_time_ns = 1'000'000 * static_cast<std::int64_t>(sample) + static_cast<std::int64_t>(sample % 7) * 1000,
            .p_WD = radius * Vec3(std::cos(angle), std::sin(angle), 0.1)};
  }
  ForceCommand reply(const DeviceState& state) {
    live.offer(state);
    return live.reply();
  }
  void slide(int steps) {
    for (int n = 0; n < steps; ++n) {
      const DeviceState state = next_state();
      recorded.emplace_back(state, reply(state));
    }
  }
  // After `samples_before` samples the hand is in free space again; 50 steps follow, in which it goes into contact again.
  void slide_in_again(std::uint64_t samples_before) {
    sample = 0;
    for (int n = 0; n < 50; ++n) {
      DeviceState state = next_state();
      state.sample += samples_before;
      state.sample_time_ns += static_cast<std::int64_t>(samples_before) * 1'000'000;
      recorded.emplace_back(state, reply(state));
    }
  }

  SessionReplay replay_with(std::unique_ptr<TouchStep> (*make)()) const {
    return SessionReplay(setups, [make](const HapticsSetup&) -> Result<std::unique_ptr<TouchStep>> { return make(); });
  }
  SessionReplay make_replay() {
    return SessionReplay(
        setups,
        [](const HapticsSetup& setup) -> Result<std::unique_ptr<TouchStep>> {
          return make_sphere_touch(parse_method_text(setup.method.data())->name.c_str());
        },
        materials,
        [](const HapticsSetup&, const MaterialState& state) -> Result<std::vector<Material>> {
          return tuned_materials(one_sphere(), state, 0.0);
        });
  }
  void feed(SessionReplay& replay) {
    for (const auto& [state, command] : recorded) {
      replay.on_state(state);
      ASSERT_TRUE(!command || replay.on_reply(kSender, *command));
    }
    ASSERT_TRUE(replay.finish());
  }
};

}  // namespace hapton
