#include "closed_loop/device_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "closed_loop/axis_plant.h"
#include "closed_loop/hand_path.h"

namespace hapton {
namespace {

// The values that the sources state for each device: docs and results quote them.
TEST(DevicePresets, AreWhatTheirSourcesSay) {
  struct Row {
    const char* name;
    double mass_kg, damping, friction_n, step_m, force_n, stiffness;
    double joint_n_per_m, mass_beyond_kg, damping_ratio;  // joint, and mass beyond it; 0: rigid
    double half_side_m, ball_radius_m;                    // workspace: half of a side, radius of the ball; 0: no ball
  };
  const Row rows[] = {{"premium-1.5", 0.075, 0.005, 0.04, 0.03e-3, 8.5, 800.0, 3500.0, 0.005, 0.2, 0.1, 0.0},
                      {"touch", 0.045, 0.1, 0.26, 0.055e-3, 3.3, 400.0, 1260.0, 0.010, 0.2, 0.075, 0.075},
                      {"omega.3", 0.22, 0.5, 0.1, 0.01e-3, 12.0, 5000.0, 14'500.0, 0.05, 0.1, 0.075, 0.075},
                      {"falcon", 0.25, 1.0, 0.5, 0.06e-3, 9.0, 1000.0, 0.0, 0.0, 0.0, 0.0508, 0.0},
                      {"wooden", 0.1, 0.2, 0.1, 0.064e-3, 5.0, 1000.0, 0.0, 0.0, 0.0, 0.1, 0.1}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    const DevicePreset* device = find_device_preset(row.name);
    ASSERT_NE(device, nullptr);
    EXPECT_EQ(device->model.mass_kg, row.mass_kg);
    EXPECT_EQ(device->model.damping_ns_per_m, row.damping);
    EXPECT_EQ(device->model.friction_n, row.friction_n);
    EXPECT_EQ(device->model.encoder_step_m, row.step_m);
    EXPECT_EQ(device->model.max_force_n, row.force_n);
    EXPECT_EQ(device->limits.max_stiffness_n_per_m, row.stiffness);
    EXPECT_DOUBLE_EQ(device->limits.max_slew_n_per_s, row.force_n / 0.004) << "to the largest force within 4 ms";
    EXPECT_EQ(device->limits.max_speed_m_per_s, 3.0);
    EXPECT_EQ(device->limits.workspace_max_m, Vec3::Constant(row.half_side_m));
    EXPECT_EQ(device->workspace_radius_m, row.ball_radius_m);
    EXPECT_EQ(device->limits.workspace_max_m, -device->limits.workspace_min_m);
    EXPECT_EQ(device->is_workspace_known, device->name != "premium-1.5") << "its source has only the 6DOF variant";
    ASSERT_EQ(device->model.mode_count, row.joint_n_per_m > 0.0 ? 1 : 0);
    if (device->model.mode_count == 0) continue;
    const StructuralMode& mode = device->model.modes[0];
    EXPECT_EQ(mode.stiffness_n_per_m, row.joint_n_per_m);
    EXPECT_EQ(mode.mass_kg, row.mass_beyond_kg);
    // The damping ratio is that of the motors, which ring on the joint while the device point is held.
    const double critical = 2.0 * std::sqrt(row.joint_n_per_m * device->model.motor_mass_kg());
    EXPECT_NEAR(mode.damping_ns_per_m / critical, row.damping_ratio, 1e-9);
  }
  EXPECT_TRUE(find_device_preset("model-a")->is_workspace_known);
}

TEST(DevicePresets, AreListedByNameAndByKind) {
  EXPECT_EQ(device_preset_names(), "model-a, model-a-6dof, premium-1.5, touch, omega.3, falcon, wooden");
  const auto names_of = [](const char* kind) {
    std::vector<std::string_view> names;
    for (const DevicePreset* device : presets_of_device(kind)) names.push_back(device->name);
    return names;
  };
  using Names = std::vector<std::string_view>;
  EXPECT_EQ(names_of("simulated-6dof"), Names{"model-a-6dof"});
  EXPECT_EQ(names_of("openhaptics"), (Names{"model-a", "premium-1.5", "touch"}));
  EXPECT_EQ(names_of("forcedimension"), (Names{"omega.3", "falcon"}));
}

TEST(DeviceModel, KeepsItsFirstModes) {
  DeviceModel model{.mass_kg = 1.0, .mode_count = 2, .modes = {StructuralMode{0.1, 10.0, 1.0}, StructuralMode{0.2, 20.0, 2.0}}};
  EXPECT_NEAR(model.motor_mass_kg(), 0.7, 1e-15);
  const std::pair<int, int> cases[] = {{-1, 0}, {0, 0}, {1, 1}, {2, 2}, {9, 2}};
  for (const auto& [max_modes, modes_left] : cases) EXPECT_EQ(model.with_modes(max_modes).mode_count, modes_left) << max_modes;
  EXPECT_NEAR(model.with_modes(1).motor_mass_kg(), 0.9, 1e-15);
  EXPECT_EQ(model.with_modes(1).modes[0].stiffness_n_per_m, 10.0);
}

// Computes forces and speeds without the matrices, for three masses: 1 kg at the motors, 2 and 3 kg (1 kg of it the hand) beyond joints.
TEST(AxisPlant, HasTheForcesOfItsJointsDampersAndHand) {
  const DeviceModel device{.mass_kg = 5.0,
                           .damping_ns_per_m = 0.5,
                           .amplifier_hz = 100.0,
                           .mode_count = 2,
                           .modes = {StructuralMode{2.0, 100.0, 3.0}, StructuralMode{2.0, 200.0, 5.0}}};
  const HandModel hand{1.0, 7.0, 50.0};
  const AxisPlant plant = make_axis_plant(device, hand);
  ASSERT_EQ(plant.states(), 7);
  EXPECT_EQ(plant.masses(), 3);
  EXPECT_TRUE(plant.has_amplifier);
  Eigen::VectorXd state(7);
  state << 0.1, 0.2, 0.3, -0.4, 0.5, 0.6, 8.0;  // x0 v0 x1 v1 x2 v2 f
  Eigen::Vector4d input(0.7, 0.8, 9.0, -1.0);   // h h' u friction
  const Eigen::VectorXd rate = plant.a * state + plant.b * input;
  const double joint_0 = 100.0 * (0.3 - 0.1) + 3.0 * (-0.4 - 0.2);
  const double joint_1 = 200.0 * (0.5 - 0.3) + 5.0 * (0.6 + 0.4);
  const double grip = 50.0 * (0.7 - 0.5) + 7.0 * (0.8 - 0.6);
  EXPECT_DOUBLE_EQ(rate[0], 0.2);
  EXPECT_DOUBLE_EQ(rate[2], -0.4);
  EXPECT_DOUBLE_EQ(rate[4], 0.6);
  EXPECT_NEAR(rate[1], (joint_0 - 0.5 * 0.2 + 8.0 - 1.0) / 1.0, 1e-9);
  EXPECT_NEAR(rate[3], (joint_1 - joint_0) / 2.0, 1e-9);
  EXPECT_NEAR(rate[5], (grip - joint_1) / 3.0, 1e-9);
  EXPECT_NEAR(rate[6], 2.0 * M_PI * 100.0 * (9.0 - 8.0), 1e-9);
}

TEST(AxisPlant, WithoutALagTheCommandActsAtOnce) {
  const AxisPlant plant = make_axis_plant({.mass_kg = 0.5, .damping_ns_per_m = 2.0}, {.mass_kg = 1.5});
  ASSERT_EQ(plant.states(), 2);
  EXPECT_FALSE(plant.has_amplifier);
  const Eigen::Vector2d rate = plant.a * Eigen::Vector2d(0.3, 0.4) + plant.b * Eigen::Vector4d(0.0, 0.0, 6.0, 1.0);
  EXPECT_NEAR(rate[0], 0.4, 1e-12);
  EXPECT_NEAR(rate[1], (6.0 + 1.0 - 2.0 * 0.4) / 2.0, 1e-12);
}

TEST(HandPath, OfNothingIsAtRestAtTheOrigin) {
  const HandPath path;
  EXPECT_EQ(path.position_m(5), Vec3(Vec3::Zero()));
  EXPECT_EQ(path.velocity_m_per_s(5), Vec3(Vec3::Zero()));
  EXPECT_EQ(path.push_n(5), Vec3(Vec3::Zero()));
  EXPECT_EQ(path.end_ns(), 0);
  EXPECT_EQ(path.next_ns(-1), std::numeric_limits<std::int64_t>::max());
}

TEST(HandPath, IsAtRestBeforeItsFirstPointAndAfterItsLast) {
  const HandPath path({{.time_ns = 100, .p_WH = {1, 0, 0}, .push_n = {1, 0, 0}},
                       {.time_ns = 200, .p_WH = {2, 0, 0}, .push_n = {2, 0, 0}},
                       {.time_ns = 400, .p_WH = {0, 0, 0}, .push_n = {3, 0, 0}}});
  struct Row {
    std::int64_t now_ns;
    double x, v, push;
    std::int64_t next_ns;
  };
  constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
  const Row rows[] = {{99, 1.0, 0.0, 0.0, 100},   {100, 1.0, 1e7, 1.0, 200},   {199, 1.99, 1e7, 1.0, 200},   {200, 2.0, -1e7, 2.0, 400},
                      {300, 1.0, -1e7, 2.0, 400}, {399, 0.01, -1e7, 2.0, 400}, {400, 0.0, 0.0, 3.0, kNever}, {900, 0.0, 0.0, 3.0, kNever}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.now_ns);
    EXPECT_NEAR(path.position_m(row.now_ns).x(), row.x, 1e-12);
    EXPECT_NEAR(path.velocity_m_per_s(row.now_ns).x(), row.v, 1e-3);
    EXPECT_EQ(path.push_n(row.now_ns).x(), row.push);
    EXPECT_EQ(path.next_ns(row.now_ns), row.next_ns);
  }
  EXPECT_EQ(path.end_ns(), 400);
}

}  // namespace
}  // namespace hapton
