#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>
#include <set>

#include "closed_loop/axis_plant.h"
#include "closed_loop/device_model.h"
#include "closed_loop/force_law.h"
#include "closed_loop/hand_model.h"
#include "closed_loop/hand_path.h"
#include "devices/stylus_dynamics.h"

namespace hapton {
namespace {

TEST(DevicePresets, AreCompleteAndHaveASourceForEachValue) {
  std::set<std::string_view> names;
  for (const DevicePreset& device : device_presets()) {
    EXPECT_TRUE(names.insert(device.name).second);
    EXPECT_GT(device.model.motor_mass_kg(), 0.0) << device.name;
    EXPECT_GT(device.model.encoder_step_m, 0.0) << device.name;
    EXPECT_EQ(device.model.max_force_n, device.limits.max_force_n) << device.name;
    for (const std::string_view source : device.sources) EXPECT_FALSE(source.empty()) << device.name;
    EXPECT_EQ(find_device_preset(device.name), &device);
  }
  EXPECT_EQ(names.size(), 7U);
  EXPECT_EQ(find_device_preset("none"), nullptr);
}

TEST(DevicePresets, AreKnownByTheKindOfDevice) {
  ASSERT_EQ(presets_of_device("simulated").size(), 1U);
  EXPECT_EQ(presets_of_device("simulated").front(), find_device_preset("model-a"));
  EXPECT_EQ(presets_of_device("WoodenHaptics").front(), find_device_preset("wooden"));
  for (const char* kind : {"openhaptics", "forcedimension"}) {
    for (const DevicePreset* device : presets_of_device(kind)) EXPECT_NE(device, nullptr) << kind;
  }
  EXPECT_TRUE(presets_of_device("replay").empty());
}

// The preset model-a and the simulated device of io_node have the same parameters.
TEST(DevicePresets, ModelAIsTheSimulatedDevice) {
  const DeviceModel& model = find_device_preset("model-a")->model;
  const StylusModel simulated;
  EXPECT_DOUBLE_EQ(model.motor_mass_kg(), simulated.device_mass_kg);
  EXPECT_DOUBLE_EQ(model.damping_ns_per_m, simulated.device_damping_n_s_per_m);
  EXPECT_DOUBLE_EQ(model.friction_n, simulated.friction_n);
  EXPECT_DOUBLE_EQ(model.modes[0].mass_kg, simulated.stylus_mass_kg);
  EXPECT_NEAR(model.modes[0].stiffness_n_per_m, simulated.structure_stiffness_n_per_m(), 1e-9);
  EXPECT_NEAR(model.modes[0].damping_ns_per_m, simulated.structure_damping_n_s_per_m(), 1e-12);
}

TEST(DeviceModel, WithoutModesHasAllItsMassAtTheMotors) {
  const DeviceModel model = find_device_preset("touch")->model;
  EXPECT_LT(model.motor_mass_kg(), model.mass_kg);
  EXPECT_EQ(model.with_modes(0).motor_mass_kg(), model.mass_kg);
}

TEST(HandPresets, GoFromNoHandToAFirmGrip) {
  EXPECT_EQ(find_hand_preset("off")->mass_kg, 0.0);
  EXPECT_LT(find_hand_preset("light")->damping_ns_per_m, find_hand_preset("firm")->damping_ns_per_m);
  EXPECT_FALSE(find_hand_preset("foot"));
  EXPECT_NE(hand_preset_names().find("stylus"), std::string::npos);
}

TEST(AxisPlant, StaticForceBendsJointsAndHandInSeries) {
  const DeviceModel device = find_device_preset("premium-1.5")->model;
  const AxisPlant plant = make_axis_plant(device, *find_hand_preset("stylus"));
  const Eigen::VectorXd rest = Eigen::MatrixXd(plant.a).fullPivLu().solve(Eigen::VectorXd(-plant.b.col(AxisPlant::command)));
  EXPECT_NEAR(rest[0], 1.0 / 500.0 + 1.0 / 3500.0, 1e-12);
}

TEST(WallLaw, PushesOnlyUnlessTwoSided) {
  WallLaw wall({.stiffness_n_per_m = 1000.0, .damping_ns_per_m = 2.0});
  wall.reset({0.0, 0.0, 0.0});
  EXPECT_NEAR(wall.step({-1e-3, 0.0, 0.0}, 1e-3).x(), 1.0 + 2.0, 1e-12);
  EXPECT_EQ(wall.step({-0.1e-3, 0.0, 0.0}, 1e-3).x(), 0.0) << "its damping does not pull";
  EXPECT_EQ(wall.step({1e-3, 0.0, 0.0}, 1e-3).x(), 0.0);
  WallLaw both({.stiffness_n_per_m = 1000.0, .two_sided = true});
  EXPECT_NEAR(both.step({1e-3, 0.0, 0.0}, 1e-3).x(), -1.0, 1e-12);
}

TEST(HandPath, GoesStraightBetweenItsPoints) {
  const HandPath path({{.time_ns = 100, .p_WH = {1.0, 0.0, 0.0}}, {.time_ns = 200, .p_WH = {3.0, 0.0, 0.0}, .push_n = {0.0, 2.0, 0.0}}});
  EXPECT_EQ(path.position_m(0).x(), 1.0);
  EXPECT_DOUBLE_EQ(path.position_m(150).x(), 2.0);
  EXPECT_DOUBLE_EQ(path.velocity_m_per_s(150).x(), 2e7);
  EXPECT_EQ(path.position_m(900).x(), 3.0);
  EXPECT_EQ(path.push_n(199).y(), 0.0);
  EXPECT_EQ(path.push_n(200).y(), 2.0);
  EXPECT_EQ(path.next_ns(100), 200);
  EXPECT_EQ(path.next_ns(200), std::numeric_limits<std::int64_t>::max());
}

}  // namespace
}  // namespace hapton
