#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "haptic_step/haptics_step.h"
#include "haptics_node/grasp_task.h"
#include "haptics_node/placed_scene.h"
#include "scene/tool_obstacles.h"

namespace hapton {

// A cube a millimetre above a plate, and a wall beside it, all with 800 N/m. The top of the plate is at z = 0, that of the cube at 0.021.
// Steps at 1 kHz; the slow task runs once a step, in the test's own thread.
struct GraspTaskTest : testing::Test {
  static constexpr int kPlate = 0;
  static constexpr int kCube = 1;
  static constexpr int kWall = 2;
  static constexpr double kSide = 0.02;
  static constexpr double kPressDepth = 0.0005;  // how deep the stylus presses

  // `change` changes the scene before it is loaded.
  explicit GraspTaskTest(const std::vector<PutDown>& put_down = {}, std::vector<SceneEffect> effects = {},
                         const std::function<void(Scene&)>& change = {}) {
    scene.effects = std::move(effects);
    scene.objects.push_back(box_at("plate", {0.2, 0.2, 0.01}, {0.0, 0.0, -0.005}));
    scene.objects.push_back(box_at("cube", Vec3::Constant(kSide), {0.0, 0.0, 0.011}, true));
    scene.objects.push_back(box_at("wall", {0.02, 0.1, 0.08}, {0.06, 0.0, 0.04}));
    if (change) change(scene);
    const Scene placed = place_objects(scene, put_down);
    auto method = make_method({}, placed.touch_scene());
    EXPECT_TRUE(method);
    step.emplace(std::make_unique<TouchStep>(std::move(*method), placed.touch_scene()), 1e-5);
    grasp.emplace(link, list_movable(scene), 1U);
    for (const PutDown& each : put_down) grasp->place(each.object, each.pose());
    step->set_grasp(&*grasp, make_tool_obstacles(placed.touch_scene()).parts);
    material_task.emplace(placed, 0.0);
    builder.emplace(MethodSettings(), placed.touch_scene(), step->touch().share_method(),
                    [this](MethodSettings& settings, const TouchScene& touched) -> Result<std::unique_ptr<ForceMethod>> {
                      if (builds_fail) return fail("no such surface");
                      built_of.push_back(touched.built);
                      return make_built_in(settings, touched);
                    });
    task.emplace(GraspTask::Options{.on_scene = [this](const TouchScene& now, std::uint32_t) { felt_scenes.push_back(now); }}, scene,
                 put_down, link, *material_task, *builder, clock);
  }

  static SceneObject box_at(const char* name, const Vec3& size, const Vec3& centre, bool is_movable = false) {
    TriangleMesh mesh = make_box(size);
    for (Vec3& vertex : mesh.vertices) vertex += centre;
    SceneObject object;
    object.name = name;
    object.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
    object.material.stiffness_n_per_m = 800.0;
    object.is_movable = is_movable;
    return object;
  }

  // Takes a method that was built, as the reply loop does.
  void take_method() {
    if (delays_methods) return;
    auto built = builder->take();
    if (built == nullptr) return;
    if (built->scene != nullptr) grasp->note_built(built->scene->put_down_serial);
    built->step = step->replace(std::move(built->step));
    if (built->scene != nullptr) step->set_materials(built->scene->materials);
    builder->retire(std::move(built));
    ++method_changes;
  }

  // One sample with the stylus at p: a step, its reply, and one run of the slow task.
  ForceCommand reply(const Vec3& p, std::uint32_t buttons, const Quat& q = Quat::Identity()) {
    ++sample;
    step->offer(
        {.sample = sample, .sample_time_ns = static_cast<std::int64_t>(sample) * 1'000'000, .p_WD = p, .q_WT = q, .buttons = buttons});
    const ForceCommand command = step->reply();
    largest_change_n = std::max(largest_change_n, (command.force_n - last_reply.force_n).norm());
    largest_change_nm = std::max(largest_change_nm, (command.torque_nm - last_reply.torque_nm).norm());
    last_reply = command;
    p_WD = p;
    task->run_once();
    take_method();
    return command;
  }
  // Moves the stylus at 50 mm/s.
  ForceCommand go(const Vec3& to, std::uint32_t buttons) {
    const Vec3 from = p_WD;
    const int steps = 1 + static_cast<int>((to - from).norm() / 5e-5);
    for (int i = 1; i <= steps; ++i) reply(from + (to - from) * i / steps, buttons);
    return rest(buttons, 150);
  }
  ForceCommand rest(std::uint32_t buttons, int steps) {
    for (int i = 0; i < steps; ++i) reply(p_WD, buttons);
    return last_reply;
  }
  // The builder works in its own thread, in real time.
  void wait_for_method(int count) {
    for (int i = 0; i < 30'000 && method_changes < count; ++i) {
      rest(0, 1);
      if (i > 50) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_EQ(method_changes, count);
  }

  // A thread describes the scene, in real time.
  const PlacedScene* wait_for_placed() {
    const PlacedScene* placed = grasp->take_placed();
    for (int i = 0; i < 30'000 && placed == nullptr; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      placed = grasp->take_placed();
    }
    return placed;
  }

  // Each reading is later than the one before by `step_ns`.
  struct PassingClock final : Clock {
    std::int64_t now_ns() const noexcept override { return time_ns += step_ns; }
    void sleep_until_ns(std::int64_t deadline_ns) noexcept override { time_ns = std::max(time_ns, deadline_ns); }
    mutable std::int64_t time_ns = 0;
    std::int64_t step_ns = 20'000'000;
  };

  Scene scene;
  PassingClock clock;
  GraspLink link;
  std::optional<HapticsStep> step;
  std::optional<Grasp> grasp;
  std::optional<MaterialTask> material_task;
  std::optional<MethodBuilder> builder;
  std::optional<GraspTask> task;
  std::uint64_t sample = 0;
  Vec3 p_WD = Vec3(0.0, 0.0, 0.05);  // of the last sample
  ForceCommand last_reply;
  double largest_change_n = 0.0;
  double largest_change_nm = 0.0;
  bool delays_methods = false;                                // no method that was built is taken
  std::atomic<bool> builds_fail = false;                      // no method can be built
  std::vector<std::shared_ptr<const BuiltObjects>> built_of;  // one per scene; the builder's thread writes it while put_down waits
  std::vector<TouchScene> felt_scenes;                        // each with an object put down
  int method_changes = 0;                                     // how many built methods have come into use
};

}  // namespace hapton
