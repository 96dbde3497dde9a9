// Materials that change while a rigid tool is pressed: force and torque fade from one to the other.
#include <cmath>

#include <gtest/gtest.h>

#include "core/math/rotation_vector.h"
#include "core/tool/held_tool.h"
#include "haptic_step/haptics_step.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kSoftNPerM = 400.0;
constexpr double kTiltRad = 0.1;

// A box of 2 cm over a sheet at z = 0, in a hand that holds it askew, 2 mm too low.
struct TiltedBox {
  TiltedBox() { step.hold(&tool); }
  ForceCommand press(double z = 0.008) {
    ++state.sample;
    state.sample_time_ns += 1'000'000;
    state.p_WD = Vec3(0.011, 0.013, z);
    step.offer(state);
    const ForceCommand reply = step.reply();
    tool.follow();
    return reply;
  }
  // Presses until everything is at rest.
  ForceCommand rest(int samples = 300) {
    ForceCommand reply;
    for (int n = 0; n < samples; ++n) reply = press();
    return reply;
  }

  TouchScene scene{.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}}};
  HeldTool tool{std::move(
      *ToolStep::make(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01)), {scene.objects[0].mesh}, {.stiffness_n_per_m = 1000.0}))};
  HapticsStep step{std::make_unique<TouchStep>(*make_method({.name = "proxy"}, scene), scene), 1e-5};
  DeviceState state{.sample = 100, .sample_time_ns = 0, .q_WT = turn_by({kTiltRad, 0.0, 0.0})};
};

ToolMaterials soft() { return {.stiffness_n_per_m = kSoftNPerM, .friction = {{}}, .damping = {{}}}; }

TEST(ToolMaterialChange, ForceAndTorqueFade) {
  TiltedBox box;
  for (int n = 0; n < 60; ++n) box.press(0.014 - 1e-4 * n);
  const ForceCommand before = box.rest();
  ASSERT_GT(before.force_n.z(), 1.0);
  ASSERT_GT(before.torque_nm.norm(), 1e-3);
  const std::vector<Material> materials(1, Material{.stiffness_n_per_m = kSoftNPerM});
  box.step.set_materials(materials, soft());
  ForceCommand last = before;
  const double full_change_n = (1.0 - kSoftNPerM / 1000.0) * before.force_n.norm();
  const double full_change_nm = (1.0 - kSoftNPerM / 1000.0) * before.torque_nm.norm();
  for (int n = 0; n < 150; ++n) {
    const ForceCommand now = box.press();
    ASSERT_LT((now.force_n - last.force_n).norm(), 0.011 * full_change_n) << n;
    ASSERT_LT((now.torque_nm - last.torque_nm).norm(), 0.011 * full_change_nm) << n;
    last = now;
  }
  EXPECT_LT((last.force_n - 0.4 * before.force_n).norm(), 1e-6);
  EXPECT_LT((last.torque_nm - 0.4 * before.torque_nm).norm(), 1e-8);
  EXPECT_EQ(last.visual_offset_m, before.visual_offset_m);
  EXPECT_EQ(last.material_serial, 1U);
}

TEST(ToolMaterialChange, InTheAirNothingIsLeftToFade) {
  // The lowest edge of the box is 0.01 mm above the sheet, where the tool already knows that it is near, and then below it.
  constexpr double kAboveM = 0.01096, kTouchingM = 0.0105;
  TiltedBox box, hard;
  for (int n = 0; n < 20; ++n) {
    EXPECT_FALSE(box.press(kAboveM).contact);
    EXPECT_FALSE(hard.press(kAboveM).contact);
  }
  box.step.set_materials(std::vector<Material>(1), soft());
  // The first sample after the change is in contact: a fade would begin here.
  for (int n = 0; n < 20; ++n) {
    const ForceCommand now = box.press(kTouchingM), of_hard = hard.press(kTouchingM);
    ASSERT_GT(of_hard.force_n.norm(), 0.1) << n;
    EXPECT_LT((now.force_n - 0.4 * of_hard.force_n).norm(), 1e-6) << n;
    EXPECT_LT((now.torque_nm - 0.4 * of_hard.torque_nm).norm(), 1e-8) << n;
  }
  EXPECT_LT((box.rest().force_n - 0.4 * hard.rest().force_n).norm(), 1e-6);
  TiltedBox lifted;
  for (int n = 0; n < 20; ++n) lifted.press(0.05);
  lifted.step.set_materials(std::vector<Material>(1), soft());
  EXPECT_FALSE(lifted.press(0.05).contact);
}

TEST(ToolMaterialChange, UsesNoHeap) {
  TiltedBox box;
  for (int n = 0; n < 60; ++n) box.press(0.014 - 1e-4 * n);
  const ToolMaterials rough{.stiffness_n_per_m = 500.0, .friction = {{0.5, 0.4}}, .damping = {{1.0, 2.0}}};
  const std::vector<Material> materials(1);
  const AllocationGuard guard;
  box.step.set_materials(materials, rough);
  box.rest(20);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
