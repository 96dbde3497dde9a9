#include "devices/wooden_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

class WoodenSettingsFile : public ::testing::Test {
 protected:
  Result<WoodenSettings> read(std::string_view text) { return read_wooden_settings(folder_.write("wooden.toml", text)); }
  std::string rejection(std::string_view text) {
    const auto settings = read(text);
    return settings ? "accepted" : settings.error().what;
  }
  ScratchFolder folder_;
};

TEST_F(WoodenSettingsFile, AnEmptyOneIsTheEditionOf2016) {
  const auto settings = read("");
  ASSERT_TRUE(settings) << settings.error().what;
  EXPECT_EQ(settings->limits.max_force_n, 5.0);
  EXPECT_EQ(settings->limits.max_slew_n_per_s, 1250.0);
  EXPECT_EQ(settings->limits.max_stiffness_n_per_m, 1000.0);
  EXPECT_EQ(settings->limits.max_speed_m_per_s, 5.0);
  EXPECT_EQ(settings->limits.workspace_min_m, Vec3::Constant(-0.1));
  EXPECT_EQ(settings->limits.workspace_max_m, Vec3::Constant(0.1));
  EXPECT_EQ(settings->arm.bodies[0].body_diameter_m, 0.160);
  EXPECT_EQ(settings->arm.bodies[1].length_m, 0.205);
  EXPECT_EQ(settings->arm.bodies[2].mass_centre_m, 0.091);
  EXPECT_EQ(settings->arm.origin_m, Vec3(0.22, 0.0, 0.08));
  EXPECT_FALSE(settings->wrist);
}

TEST_F(WoodenSettingsFile, EveryNumberOfABuildCanBeNamed) {
  const auto settings = read(R"(
max_force_n = 9.5
max_slew_n_per_s = 800
max_stiffness_n_per_m = 700
continuous_force_n = 3.5
peak_s = 6
max_speed_m_per_s = 2
max_current_a = 2.0
workspace_radius_m = 0.15
origin_m = [0.1, 0.0, 0.2]
gravity_compensation = false
report_bytes = 14
[body_a]
body_diameter_m = 0.18
direction = -1
[body_c]
length_m = 0.3
rest_deg = 90
[[wrist]]
axis = [0, 0, 0.5]
counts_per_turn = 4096
[[wrist]]
axis = [0, 1, 0]
direction = -1
[[wrist]]
axis = [1, 0, 0]
offset_deg = 180
)");
  ASSERT_TRUE(settings) << settings.error().what;
  EXPECT_EQ(settings->limits.max_force_n, 9.5);
  EXPECT_EQ(settings->limits.max_slew_n_per_s, 800.0);
  EXPECT_EQ(settings->limits.max_stiffness_n_per_m, 700.0);
  EXPECT_EQ(settings->limits.continuous_force_n, 3.5);
  EXPECT_EQ(settings->limits.peak_s, 6.0);
  EXPECT_EQ(settings->limits.max_speed_m_per_s, 2.0);
  EXPECT_EQ(settings->limits.workspace_min_m, Vec3::Constant(-0.15));
  EXPECT_EQ(settings->max_current_a, 2.0);
  EXPECT_FALSE(settings->has_gravity_compensation);
  EXPECT_EQ(settings->report_bytes, 14);
  EXPECT_EQ(settings->arm.bodies[0].direction, -1.0);
  EXPECT_NEAR(settings->arm.bodies[2].rest_rad, 0.5 * std::numbers::pi, 1e-12);
  ASSERT_TRUE(settings->wrist);
  EXPECT_EQ(settings->wrist->joints[0].axis, Vec3::UnitZ());
  EXPECT_EQ(settings->wrist->joints[0].counts_per_turn, 4096.0);
  EXPECT_EQ(settings->wrist->joints[1].direction, -1.0);
  EXPECT_NEAR(settings->wrist->joints[2].offset_rad, std::numbers::pi, 1e-12);
}

// Each number is different, so that the test fails if two are interchanged: the force would be too large or have a wrong direction.
TEST_F(WoodenSettingsFile, EveryNumberOfABodyIsItsOwn) {
  const auto settings = read(R"(
origin_m = [0.1, 0.02, 0.2]
[body_b]
capstan_diameter_m = 0.011
body_diameter_m = 0.13
length_m = 0.19
counts_per_turn = 4096
torque_constant_nm_per_a = 0.03
direction = -1
rest_deg = 18
mass_kg = 0.21
mass_centre_m = 0.06
)");
  ASSERT_TRUE(settings) << settings.error().what;
  EXPECT_EQ(settings->arm.origin_m, Vec3(0.1, 0.02, 0.2));
  const WoodenArm::Body& body = settings->arm.bodies[1];
  EXPECT_EQ(body.capstan_diameter_m, 0.011);
  EXPECT_EQ(body.body_diameter_m, 0.13);
  EXPECT_EQ(body.length_m, 0.19);
  EXPECT_EQ(body.counts_per_turn, 4096.0);
  EXPECT_EQ(body.torque_constant_nm_per_a, 0.03);
  EXPECT_EQ(body.direction, -1.0);
  EXPECT_NEAR(body.rest_rad, 0.1 * std::numbers::pi, 1e-12);
  EXPECT_EQ(body.mass_kg, 0.21);
  EXPECT_EQ(body.mass_centre_m, 0.06);
  EXPECT_EQ(settings->arm.bodies[0].torque_constant_nm_per_a, 0.0259) << "the others are as they were";
}

TEST_F(WoodenSettingsFile, AnImpossibleValueIsRejectedWithItsLine) {
  EXPECT_THAT(rejection("\nmax_force = 5\n"), HasSubstr("wooden.toml:2"));
  EXPECT_THAT(rejection("max_force_n = 1e9"), HasSubstr("max_force_n"));
  EXPECT_THAT(rejection("max_force_n = nan"), HasSubstr("max_force_n"));
  EXPECT_THAT(rejection("[body_a]\ncapstan_diameter_m = 0"), HasSubstr("wooden.toml:2"));
  EXPECT_THAT(rejection("[body_b]\ndirection = 0.5"), HasSubstr("'direction' is 1, or -1"));
  EXPECT_THAT(rejection("[body_a]\ncounts_per_turn = 1e5"), HasSubstr("must hold half a turn"));
  EXPECT_THAT(rejection("[[wrist]]\naxis = [0, 0, 1]\ncounts_per_turn = 70000\n[[wrist]]\naxis = [0, 1, 0]\n[[wrist]]\naxis = [1, 0, 0]"),
              HasSubstr("counts_per_turn"));
  EXPECT_THAT(rejection("report_bytes = 9"), HasSubstr("'report_bytes' is 8 or 14"));
  EXPECT_THAT(rejection("[[wrist]]\naxis = [1, 0, 0]"), HasSubstr("three times"));
  EXPECT_THAT(rejection("[[wrist]]\naxis = [0, 0, 0]\n[[wrist]]\naxis = [0, 0, 1]\n[[wrist]]\naxis = [0, 1, 0]"), HasSubstr("zero length"));
  EXPECT_THAT(rejection("[[wrist]]\n[[wrist]]\n[[wrist]]\n"), HasSubstr("axis"));
}

TEST_F(WoodenSettingsFile, OneThatIsNotThereIsAnErrorInOneLine) {
  const auto settings = read_wooden_settings(folder_.path() / "none.toml");
  ASSERT_FALSE(settings);
  EXPECT_THAT(settings.error().what, HasSubstr("none.toml"));
}

}  // namespace
}  // namespace hapton
